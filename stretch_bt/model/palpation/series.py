"""A soft object in series with the membrane: its whole curve of force over drop, fitted to heights of its top."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.model.force.force_model import ForceModel, change_by_size, check_model
from stretch_bt.model.force.local import LocalReading, local_forces
from stretch_bt.model.palpation.balance import FLATTEST, LAW, STEEPEST, Balance, presses_of
from stretch_bt.model.palpation.law import ObjectLaw
from stretch_bt.plain_numbers import is_number
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS, Estimate

__all__ = ["POWER", "STIFFENING", "Series", "TopReading", "fit_series"]

Array = npt.NDArray[np.float64]

#: exponent of an object's force law at slight deflections: a spring 1, filled balloons 1.17 to 1.25, an elastic ball 1.5
POWER = Estimate(1.3, 0.3)
#: growth of the exponent with each millimetre of drop: filled balloons 0.1 to 0.2, springs and elastic balls 0
STIFFENING = Estimate(0.03, 0.06)
ROBOT = 5e-5  # m; standard deviation of where the hand stands about where it was sent, from press to press
SIGNIFICANT = 3.0  # standard deviations; only a drop that exceeds 0 by more carries a stiffness


@dataclass(frozen=True, slots=True)
class TopReading:
    """The height of an object's top, m, world, with its sd, seen at a stretch by a hand whose flat membrane stands at `hand`, m."""

    stretch: float
    hand: float
    height: float
    sd: float


@dataclass(frozen=True, slots=True)
class Series:
    """The object as the readings show it: its law (`ObjectLaw`), and where the last press stands on that.

    `top` is the height of the undeformed top, `height` the height of the top at the last press, `drop` their difference;
    `force` is the force on the object at the last press, by the force model; its sd includes the errors of the model, the radius and
    all heights alike.
    """

    top: Estimate
    height: Estimate
    drop: Estimate
    force: Estimate
    power: Estimate
    together: float  # correlation of the errors of force and drop
    secant: Estimate  # force over drop at the last press, N/m; infinite where there is no drop
    chi2: float  # of the readings, over the degrees of freedom; 1 where they scatter as they say
    compliance: Estimate  # drop at the force of the last reading, m
    reference: float  # that force, N
    force_sd: float  # relative sd of force, from the model, the radius and the error that all heights share
    stiffening: Estimate  # growth of the power with each millimetre of drop
    covariance: Array  # (4, 4) of top, compliance, power and stiffening

    @property
    def law(self) -> ObjectLaw:
        """The object's force law, whose reference is the force of the last reading."""
        return ObjectLaw(self.compliance.value, self.power.value, self.stiffening.value)

    def stiffness(self) -> Estimate:
        """Return force over drop at the last press, N/m.

        Raises
        ------
        IllConditioned
            The drop is not more than three standard deviations above zero.
        """
        self._require_drop()
        return self.secant

    def stiffness_at(self, drop: float) -> Estimate:
        """Return force over drop, N/m, at a drop, m, on the curve; raises IllConditioned as `stiffness` does."""
        force = self.force_at(drop)
        return Estimate(force.value / drop, math.hypot(force.sd, force.value * self.force_sd) / drop)

    def force_at(self, drop: float) -> Estimate:
        """Return the force, N, at a drop, m; its sd is from the readings alone, the force model taken as right."""
        if not (is_number(drop) and drop > 0):
            raise InvalidInput(f"drop must be finite and above 0 m, not {shown(drop)[:80]}")
        self._require_drop()
        logarithm, by_law = self.law.log_force(drop)
        force = self.reference * math.exp(logarithm)
        row = np.array([0.0, *by_law])
        return Estimate(force, force * self._sd_along(row))

    def drop_at(self, force: float) -> Estimate:
        """Return the drop, m, at a force, N, above 0, with the sd of the readings; also where it is not above zero yet."""
        drop, by_law = self._drop(force)
        return Estimate(drop, self._sd_along(np.array([0.0, *by_law])))

    def height_at(self, force: float) -> Estimate:
        """Return the height of the top, m, at a force, N, above 0, with the sd of the readings."""
        drop, by_law = self._drop(force)
        return Estimate(self.top.value - drop, self._sd_along(np.array([1.0, *-by_law])))

    def _drop(self, force: float) -> tuple[float, Array]:
        """Return the drop, m, at a force, N, and its derivatives by the law (3,)."""
        if not (is_number(force) and force > 0):
            raise InvalidInput(f"force must be finite and above 0 N, not {shown(force)[:80]}")
        drops, _, by_law = self.law.deflection(np.log(np.array([force / self.reference])))
        return float(drops[0]), by_law[0]

    def _sd_along(self, row: Array) -> float:
        """Return the standard deviation of a quantity with these derivatives by top and law; rounding may make a variance negative."""
        return math.sqrt(max(float(row @ self.covariance @ row), 0.0))

    def _require_drop(self) -> None:
        if self.drop.value <= SIGNIFICANT * self.drop.sd or self.compliance.value <= 0:
            raise IllConditioned(self.too_little())

    def too_little(self) -> str:
        """Return the words that say how little the object gave way, and its least stiffness."""
        lost, error = (format_quantity(v, KINDS["Length"]) for v in (self.drop.value, self.drop.sd))
        most = max(self.drop.value, 0.0) + 2 * self.drop.sd
        least = format_quantity(self.force.value / most, KINDS["Stiffness"]) if most > 0 else "infinite"
        return (
            f"under {self.force.value:.2f} N the object's top gave way by {lost} with a standard deviation of {error}: "
            f"too little to tell; its stiffness is above about {least}"
        )


def fit_series(
    model: ForceModel,
    radius: Estimate,
    readings: Sequence[LocalReading],
    *,
    top: Estimate | None = None,
    power: Estimate = POWER,
    stiffening: Estimate = STIFFENING,
    robot_sd: float = ROBOT,
    common_sd: float = 0.0,
) -> Series:
    """Fit the object's curve of force over drop to readings of its top; the last one is of the present press.

    Membrane and object carry the same force: F_model(stretch, h - hand) = F_object(top - h), the latter by `ObjectLaw`. Each reading's
    height h follows from that for the unknown top, compliance, power and stiffening, which Gauss-Newton finds. Its weights come from the
    readings' own errors, sd, and from that of the model's force, drop dF/F / exponent with dF the model's sd, which all readings of
    one press share; `power` and `stiffening` are priors.
    At each press the hand stands above or below where it was
    sent by an unknown of its own, with prior 0 and sd `robot_sd`: the depth that a camera on the hand measures is right, and the height computed
    from it is off by that. A factor common to all forces leaves the drops as they are. Where readings scatter more than they say, all sds
    grow by the root of chi2.

    Parameters
    ----------
    model, radius
        The hand's force law, and the radius of the sphere in contact, m.
    readings
        In the order they were taken, so that all of one press follow each other; one that is not above its hand counts for the top alone.
    top
        The height of the undeformed top, where it is known otherwise.
    robot_sd
        Standard deviation of where the hand stands about where it was sent, m, from press to press.
    common_sd
        Standard deviation of the error that all heights share, m: it changes the force, and not the drop. `top` and `height` leave it out.

    Raises
    ------
    IllConditioned
        The readings are too few, all of one press or all at one force, the last hand stands above the top, the curve does not settle, or
        the model's force falls with depth.
    InvalidInput
        A number is not finite or has the wrong sign, or a reading lies outside the model's range.
    """
    check_model(model)
    _check(radius, readings, top, power, stiffening, robot_sd=robot_sd, common_sd=common_sd)
    forces = local_forces(model, radius.value, readings)
    _enough(forces.force, readings, top)
    fit = Balance(forces, readings, top, power, stiffening, robot_sd)
    fit.solve()
    return _concluded(model, radius, readings[-1], fit, common_sd)


def _concluded(model: ForceModel, radius: Estimate, last: LocalReading, fit: Balance, common_sd: float) -> Series:
    """Return the fit at the last reading's pose."""
    heights, rows = fit.curve(fit.q)
    height, row, sunk = float(heights[-1]), rows[-1], fit.depths(rows)[-1]
    depths = heights - fit.hand - fit.off
    if not depths[-1] > 0:
        raise IllConditioned("the hand is not past the undeformed top, so that this press says nothing of a drop")
    lowest, highest = model.range.depth
    depth = min(max(float(depths[-1]), lowest), highest)
    force, model_sd = model.predict(radius.value, last.stretch, depth)
    slope = float(fit.forces.at(depths)[1][-1])
    sized = change_by_size(model, radius, last.stretch, depth)
    force_sd = math.hypot(model_sd, sized, slope * common_sd) / force if force > 0 else 0.0
    drop_row = np.eye(len(row))[0] - row
    drop = fit.q[0] + fit.level - height
    secant = Estimate(math.inf, math.inf)
    if drop > 0:
        both = (slope * sunk - force / drop * drop_row) / drop
        secant = Estimate(force / drop, math.hypot(fit.sd_along(both), force_sd * force / drop))
    force_at_all = math.hypot(force_sd * force, slope * fit.sd_along(sunk))
    drop_sd = fit.sd_along(drop_row)
    return Series(
        top=Estimate(fit.q[0] + fit.level, math.sqrt(fit.covariance[0, 0])),
        height=Estimate(height, fit.sd_along(row)),
        drop=Estimate(drop, drop_sd),
        force=Estimate(force, force_at_all),
        power=Estimate(float(fit.q[2]), math.sqrt(fit.covariance[2, 2])),
        together=slope * float(sunk @ fit.covariance @ drop_row) / max(force_at_all * drop_sd, 1e-300),
        secant=secant,
        chi2=fit.chi2,
        compliance=Estimate(float(fit.q[1]), math.sqrt(fit.covariance[1, 1])),
        reference=float(fit.forces.force[-1]),
        force_sd=force_sd,
        stiffening=Estimate(float(fit.q[3]), math.sqrt(fit.covariance[3, 3])),
        covariance=fit.covariance[:LAW, :LAW],
    )


def _enough(force: Array, readings: Sequence[LocalReading], top: Estimate | None) -> None:
    if top is None and (presses_of(readings)[-1] == 0 or np.ptp(force) <= 1e-3 * force.max()):
        raise IllConditioned(
            "readings of one press or at one force do not show how far the object gives way; press at two or more"
        )


def _check(
    radius: Estimate,
    readings: Sequence[LocalReading],
    top: Estimate | None,
    power: Estimate,
    stiffening: Estimate,
    **sds: float,
) -> None:
    check_estimates(radius=radius, power=power, stiffening=stiffening, **({} if top is None else {"top": top}))
    if radius.value <= 0:
        raise InvalidInput(f"radius must be finite and above 0 m, with a standard deviation of 0 or more, not {radius}")
    _check_readings(readings)
    if top is not None and top.sd == 0:
        raise InvalidInput(f"top must be finite with a standard deviation above 0 m, not {top}")
    if not (power.sd > 0 and FLATTEST <= power.value <= STEEPEST):
        raise InvalidInput(f"power must lie within {FLATTEST} to {STEEPEST} with an sd above 0, not {power}")
    if stiffening.sd == 0:
        raise InvalidInput(f"stiffening must be finite with a standard deviation above 0, not {stiffening}")
    for name, sd in sds.items():
        if not (is_number(sd) and sd >= 0):
            raise InvalidInput(f"{name} must be finite and at least 0 m, not {shown(sd)[:80]}")


def _check_readings(readings: Sequence[LocalReading]) -> None:
    """Refuse an input that is no list of readings, and readings that are not finite."""
    try:
        values = np.array([(r.stretch, r.hand, r.height, r.sd) for r in readings], dtype=float)
    except (TypeError, ValueError, AttributeError):
        raise InvalidInput(f"readings are a list of TopReading, m, not {shown(readings)[:80]}") from None
    if not len(values):
        raise IllConditioned(
            "there is no reading of the object's top, so that no curve can be fitted; press at two depths or more"
        )
    if not np.all(np.isfinite(values)) or np.any(values[:, 3] <= 0):
        raise InvalidInput("readings must be finite, m, and their standard deviations above 0 m")
