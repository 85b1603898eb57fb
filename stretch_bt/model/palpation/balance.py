"""Gauss-Newton for the curve of an object that carries the same force as the membrane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.model.force.local import LocalForces, LocalReading
from stretch_bt.model.palpation.law import MM, SOFTEST, ObjectLaw
from stretch_bt.units import Estimate

__all__ = ["FLATTEST", "LAW", "SAME", "STEEPEST", "Balance", "presses_of"]

Array = npt.NDArray[np.float64]

STEEPEST, FLATTEST = 4.0, 0.5  # powers between which a fit is held
SAME = 2e-4  # m, within which two readings are of one press: the hand is held better, and a step is larger
STANDS = 1e-9  # m; a smaller sd of where the hand stands makes no difference
ROUNDS = 40
SETTLED = 1e-12  # m
LAW = 4  # how many of q are of top and law
PURE = [2, 3]  # of them without a unit: power and stiffening
LEAST = 1e-300  # keeps 0 / 0 out where the model's force has no error
LEFT = 0.1  # standard deviations; largest last step of a settled answer


def presses_of(readings: Sequence[LocalReading]) -> npt.NDArray[np.int64]:
    """Return the number (n,) of each reading's press: another one begins where hand or stretch are not those it began with."""
    numbers, begun = [-1], readings[:1]
    for reading in readings:
        same = reading.stretch == begun[0].stretch and abs(reading.hand - begun[0].hand) < SAME
        begun = begun if same else [reading]
        numbers.append(numbers[-1] + (not same or numbers[-1] < 0))
    return np.array(numbers[1:], dtype=np.int64)


class Balance:
    """The fit over q = (top, compliance, power, stiffening, and by how much the hand stands above where it was sent at each press).

    A reading measures a depth of the membrane below the hand, and so the height of the top only as far as the hand's is known:
    the reported height is the height in force balance less the distance that the hand stands off.
    """

    def __init__(
        self,
        forces: LocalForces,
        readings: Sequence[LocalReading],
        top: Estimate | None,
        power: Estimate,
        stiffening: Estimate,
        robot: float,
    ) -> None:
        self.forces, self.power, self.stiffening, self.top, self.robot = forces, power, stiffening, top, robot
        self.hand, self.height, self.sd = (
            np.array([getattr(r, n) for r in readings]) for n in ("hand", "height", "sd")
        )
        press = presses_of(readings)
        self.same = press[:, None] == press
        self.of_press = np.eye(press[-1] + 1)[press] if robot > STANDS else np.zeros((len(readings), 0))
        self.level = float(np.mean(self.height))
        self.q = self._begun()
        self.whitening = np.diag(1 / self.sd)

    def solve(self) -> None:
        """Find q, with the weights of the drops found, and the covariance; raises IllConditioned where the readings do not determine it."""
        for _ in range(ROUNDS):
            height, rows = self.curve(self.q)
            self.whitening = self._whitened(height, rows)
            before, self.q = self.q, self._stepped(*self._stacked(height, rows))
            step = self.q - before
            if np.abs(np.delete(step, PURE)).sum() < SETTLED and np.abs(step[PURE]).sum() < 1e-9:
                break
        design, left = self._stacked(*self.curve(self.q))
        free = len(left) - len(self.q)
        self.chi2 = float(left @ left) / free if free > 0 else 1.0
        try:
            self.covariance = np.asarray(np.linalg.inv(design.T @ design)) * max(1.0, self.chi2)
        except np.linalg.LinAlgError:
            raise IllConditioned("the readings do not tell how far the object gives way; press deeper") from None
        if not np.all(np.abs(step) <= LEFT * np.sqrt(np.maximum(np.diag(self.covariance), 0.0))):
            raise IllConditioned("the curve through the readings does not settle; look again, or press deeper")

    def _stepped(self, design: Array, left: Array) -> Array:
        """Return the next q; where the power would leave its bounds it stays at the nearer one, and the rest is fitted to that."""
        step, *_ = np.linalg.lstsq(design, left, rcond=None)
        q = self.q + step
        power = min(max(q[2], FLATTEST), STEEPEST)
        if power != q[2]:
            bent = design[:, 2] * (power - self.q[2])
            rest, *_ = np.linalg.lstsq(np.delete(design, 2, axis=1), left - bent, rcond=None)
            q = np.insert(np.delete(self.q, 2) + rest, 2, power)
        return self._held(q)

    @property
    def off(self) -> Array:
        """By how much the hand stands above where it was sent, of each reading (n,), m."""
        return self._off(self.q)

    def _off(self, q: Array) -> Array:
        return np.asarray(self.of_press @ q[LAW:])

    def curve(self, q: Array) -> tuple[Array, Array]:
        """Return the height of the top at each reading (n,), m, and its derivatives by q (n, 4 + presses)."""
        top, law = q[0] + self.level, ObjectLaw(*q[1:LAW])
        hand = self.hand + self._off(q)
        height = self.height.copy()
        for _ in range(ROUNDS):
            drop, slope, _ = self._drop(height - hand, law)
            step = (top - drop - height) / (1 + slope)
            height = height + step
            if np.max(np.abs(step)) < SETTLED:
                break
        _, slope, by_law = self._drop(height - hand, law)
        rows = np.hstack([np.ones((len(height), 1)), -by_law, slope[:, None] * self.of_press])
        return height, rows / (1 + slope)[:, None]

    def depths(self, rows: Array) -> Array:
        """Return the derivatives by q of the membrane's depths, and of reported heights (n, 4 + presses), from the heights' derivatives."""
        return rows - np.pad(self.of_press, ((0, 0), (LAW, 0)))

    def sd_along(self, row: Array) -> float:
        """Return the standard deviation of a quantity with these derivatives by q."""
        return float(np.sqrt(max(float(row @ self.covariance @ row), 0.0)))

    def _drop(self, depth: Array, law: ObjectLaw) -> tuple[Array, Array, Array]:
        """Return the object's drop under the force at each depth (n,), its derivative by depth, and its derivatives by the law (n, 3)."""
        force, slope = self.forces.at(depth)
        pressed = force > 0
        share = np.where(pressed, np.maximum(force, 1e-300), self.forces.force[-1]) / self.forces.force[-1]
        drop, exponent, rows = law.deflection(np.log(share))
        steep = drop * slope / (np.maximum(force, 1e-300) * exponent)
        return np.where(pressed, drop, 0.0), np.where(pressed, steep, 0.0), np.where(pressed[:, None], rows, 0.0)

    def _whitened(self, height: Array, rows: Array) -> Array:
        """Return the matrix (n, n), 1/m, whose product with the errors about the curve is independent with a standard deviation of 1.

        Each reading has an error of its own, and those of one press share that of the model's force there.
        """
        drop = np.abs(self.q[0] + self.level - height)
        exponent = np.maximum(self.q[2] + self.q[3] * drop / MM, 0.1 * self.q[2])
        shared = drop * self.forces.relative_sd / exponent * rows[:, 0] / self.sd
        total = (self.same @ shared**2)[:, None]
        along = self.same * np.outer(shared, shared) / np.maximum(total, LEAST)
        # the inverse root of 1 + shared shared' keeps what is across the shared error, however small a reading's own is
        whitened: Array = (np.eye(len(drop)) - along + along / np.sqrt(1 + total)) / self.sd
        return whitened

    def _stacked(self, height: Array, rows: Array) -> tuple[Array, Array]:
        """Return the weighted design and the residuals, the priors of power, stiffening, top and the hand's places among them."""
        priors = [(k, prior.value, prior.sd) for k, prior in zip(PURE, (self.power, self.stiffening), strict=True)]
        if self.top is not None:
            priors.append((0, self.top.value - self.level, self.top.sd))
        priors += [(k, 0.0, self.robot) for k in range(LAW, len(self.q))]
        at, values, sds = (np.array(column) for column in zip(*priors, strict=True))
        design = np.vstack([self.whitening @ self.depths(rows), np.eye(len(self.q))[at] / sds[:, None]])
        left = self.whitening @ (self.height + self.off - height)
        return design, np.append(left, (values - self.q[at]) / sds)

    def _begun(self) -> Array:
        """Return the q of plain least squares at the power of the prior."""
        share = (self.forces.force / self.forces.force[-1]) ** (1 / self.power.value)
        design = np.column_stack([np.ones_like(share), -share]) / self.sd[:, None]
        values = (self.height - self.level) / self.sd
        if self.top is not None:
            design = np.vstack([design, [1 / self.top.sd, 0.0]])
            values = np.append(values, (self.top.value - self.level) / self.top.sd)
        found, *_ = np.linalg.lstsq(design, values, rcond=None)
        return self._held(np.array([*found, self.power.value, 0.0, *np.zeros(self.of_press.shape[1])]))

    def _held(self, q: Array) -> Array:
        """Keep the compliance above where membrane and object would run away."""
        share = self.forces.force / self.forces.force[-1]
        steep = np.max(share ** (1 / q[2]) * self.forces.power / self.forces.depth)
        least = -0.3 * q[2] / steep if np.isfinite(steep) and steep > 0 else 0.0
        compliance = max(q[1], least)
        softest = SOFTEST * q[2] / (abs(compliance) / MM + 1e-9)
        stiffening = max(q[3], softest) if compliance > 0 else min(q[3], -softest)
        return np.array([q[0], compliance, q[2], stiffening, *q[LAW:]])
