"""The paper's force law: an effective modulus from calibration, then Hertz contact with a sphere."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model.checks import MOST_SD, require_correlation, require_within
from stretch_bt.model.force.force_model import MOST, ForceModel, Range, require_force
from stretch_bt.plain_numbers import is_number
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS

__all__ = ["MOST_SHALLOW", "SHALLOW", "CalibratedHertz", "StretchState", "to_logarithm"]

Array = npt.NDArray[np.float64]

SHALLOW = 5e-3  # m; at lesser depths a membrane does not follow the formula of Hertz
MOST_SHALLOW = 100.0  # of `shallow_sd`
MOST_LOG_SCALE_SD = 5.0  # of `log_scale_sd`

_STIFF = 4 / 3 / (1 - 0.5**2)  # of a sphere on an incompressible half-space, as `hertz_force` has it
_LENGTH = KINDS["Length"]
_LEAST_SCALE, _MOST_SCALE = 1e-6, 10.0  # m


@dataclass(frozen=True, slots=True)
class StretchState:
    """E*(diameter) = floor + amplitude exp(-diameter / decay) at one stretch; m and Pa, each with its sd."""

    stretch: float
    floor: float
    floor_sd: float
    amplitude: float
    amplitude_sd: float
    decay: float
    decay_sd: float

    def __post_init__(self) -> None:
        values = [getattr(self, f.name) for f in fields(self)]
        if not all(map(is_number, values)):
            raise InvalidInput(f"a stretch state needs finite numbers, got {str(self)[:200]}")
        require_within("states.stretch", self.stretch, 0.0, MOST["stretch"])
        if self.decay <= 0 or min(self.floor_sd, self.amplitude_sd, self.decay_sd) < 0:
            raise InvalidInput(f"a stretch state needs a decay above 0 and no negative sd, got {self}")

    def modulus(self, diameter: float) -> tuple[float, float]:
        """Return E*, Pa, for a diameter, m, and its variance, with the parameters taken as independent."""
        falling = math.exp(-diameter / self.decay)
        slope = self.amplitude * falling * diameter / self.decay**2
        variance = self.floor_sd**2 + (falling * self.amplitude_sd) ** 2 + (slope * self.decay_sd) ** 2
        return self.floor + self.amplitude * falling, variance


@dataclass(frozen=True)
class CalibratedHertz(ForceModel):
    """The paper's model: E* a negative exponential in diameter at each stretch, a logarithm across stretches.

    E*(x) = p + q ln(1 + x / log_scale) is fitted by least squares to the states' E* at the sphere's diameter; the
    force follows from the Hertz sphere. `log_scale_sd` is the standard deviation of the scale's logarithm, and `correlation`
    (3 n, 3 n) holds the floors of the n states, then their amplitudes, then their decays; without it they are independent.
    `relative_sd` is the residual of the law itself, as a part of the force; at depths below
    5 mm the error `shallow_sd` (1 - depth / 5 mm)^2 is added to it in squares: a membrane that is pressed slightly follows another
    power of depth than the formula of Hertz.
    """

    kind: ClassVar[str] = "calibrated_hertz"
    states: tuple[StretchState, ...]
    log_scale: float
    relative_sd: float
    range: Range
    provenance: dict[str, Any] = field(default_factory=dict)
    shallow_sd: float = 0.0
    log_scale_sd: float = 0.0
    correlation: tuple[tuple[float, ...], ...] | None = None

    def __post_init__(self) -> None:
        if len({state.stretch for state in self.states}) < 2:
            raise InvalidInput("a calibration needs at least two different stretches, to determine how E* rises")
        require_within("log_scale", self.log_scale, _LEAST_SCALE, _MOST_SCALE)
        require_within("relative_sd", self.relative_sd, 0.0, MOST_SD)
        require_within("shallow_sd", self.shallow_sd, 0.0, MOST_SHALLOW)
        require_within("log_scale_sd", self.log_scale_sd, 0.0, MOST_LOG_SCALE_SD)
        if self.correlation is not None:
            require_correlation("correlation", self.correlation, 3 * len(self.states))

    @cached_property
    def _fits(self) -> list[tuple[float, Array]]:
        """The scale, and one standard deviation below and above it, each with the map (2, states) from the states' moduli to p and q."""
        scales = [self.log_scale * math.exp(k * self.log_scale_sd) for k in (0, -1, 1)[: 3 if self.log_scale_sd else 1]]
        return [(scale, to_logarithm(self._columns[0], scale)) for scale in scales]

    @cached_property
    def _columns(self) -> Array:
        """(7, states) float: stretch, then floor, amplitude and decay, then their standard deviations."""
        names = ("stretch", "floor", "amplitude", "decay", "floor_sd", "amplitude_sd", "decay_sd")
        return np.array([[getattr(state, name) for state in self.states] for name in names])

    @cached_property
    def _root(self) -> Array | None:
        """(3 n, 3 n) float: what makes the parameters' deviations, in their order, of independent ones."""
        if self.correlation is None:
            return None
        values, vectors = np.linalg.eigh(np.array(self.correlation))
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))

    def _moduli(self, diameter: float) -> tuple[Array, Array]:
        """Return the states' moduli (n,) at a diameter, m, and by how much the parameters' deviations change them (3, n), Pa."""
        _, floor, amplitude, decay, *sds = self._columns
        falling = np.exp(-diameter / decay)
        slope = amplitude * falling * diameter / decay**2
        return floor + amplitude * falling, np.array([sds[0], falling * sds[1], slope * sds[2]])

    def _logarithm(self, diameter: float) -> tuple[float, float]:
        """Return p and q at a diameter, m."""
        p, q = (self._fits[0][1] @ self._moduli(diameter)[0]).tolist()
        return p, q

    def modulus(self, radius: float, stretch: float) -> tuple[float, float]:
        """Return the effective modulus, Pa, that a sphere of this radius meets, and its standard deviation."""
        modulus, sd = self.fitted_modulus(radius, stretch)
        if not modulus > 0.0:
            raise NoEquilibrium(
                f"the calibration has no modulus above 0 for a radius of {format_quantity(radius, _LENGTH)} at stretch "
                f"{format_quantity(stretch, _LENGTH)}; measure more stretches and diameters, or calibrate another model"
            )
        return modulus, sd

    def fitted_modulus(self, radius: float, stretch: float) -> tuple[float, float]:
        """Return what the fit says of the modulus, Pa, also where that is none, and its standard deviation."""
        self.range.check(radius=radius, stretch=stretch)
        moduli, changes = self._moduli(2 * radius)
        rows = [fit[0] + math.log1p(stretch / scale) * fit[1] for scale, fit in self._fits]
        found, *others = (float(row @ moduli) for row in rows)
        by_parameters = (rows[0] * changes).ravel()
        if self._root is not None:
            by_parameters = by_parameters @ self._root
        by_scale = (others[1] - others[0]) / 2 if others else 0.0
        return found, math.hypot(by_scale, math.sqrt(float(by_parameters @ by_parameters)))

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        """Return the force, N, and its standard deviation."""
        self.range.check(depth=depth)
        modulus, sd = self.modulus(radius, stretch)
        force = _STIFF * modulus * math.sqrt(depth**3 * radius)
        shallow = self.shallow_sd * max(1 - depth / SHALLOW, 0.0) ** 2
        return force, force * math.hypot(self.relative_sd, shallow, sd / modulus)

    def depth_for(self, radius: float, stretch: float, force: float) -> float:
        """Return the depth, m, at which the force, N, is this one."""
        require_force(force)
        modulus, _ = self.modulus(radius, stretch)
        depth: float = (force / (_STIFF * modulus * math.sqrt(radius))) ** (2 / 3)
        deepest = self.range.depth[1]
        if depth > deepest * (1 + 1e-12):
            raise NoEquilibrium(
                f"{force:.3g} N needs a depth of {format_quantity(depth, _LENGTH)} at stretch "
                f"{format_quantity(stretch, _LENGTH)}, past the calibrated {format_quantity(deepest, _LENGTH)}"
            )
        return min(depth, deepest)

    def stretch_for(self, radius: float, depth: float, force: float) -> float:
        """Return the stretch, m, at which the force, N, is this one."""
        require_force(force)
        self.range.check(radius=radius, depth=depth)
        if depth == 0:
            raise NoEquilibrium("no stretch gives a force at depth 0")
        p, q = self._logarithm(2 * radius)
        wanted = force / (_STIFF * math.sqrt(depth**3 * radius))
        least, most = self.range.stretch
        ends = sorted(p + q * math.log1p(x / self.log_scale) for x in (least, most))
        if q == 0 or not ends[0] * (1 - 1e-12) <= wanted <= ends[1] * (1 + 1e-12):
            weakest, strongest = (force / wanted * e if wanted else 0.0 for e in ends)
            raise NoEquilibrium(
                f"no stretch gives {force:.4g} N at a depth of {format_quantity(depth, _LENGTH)}"
                + (f"; the calibrated stretches give {weakest:.4g} to {strongest:.4g} N" if wanted else "")
            )
        return min(max(self.log_scale * math.expm1((wanted - p) / q), least), most)

    def to_json(self) -> dict[str, Any]:
        """Return the parameters, SI."""
        return {
            "provenance": self.provenance,
            "units": "SI: m, Pa; relative_sd and shallow_sd are parts of the force",
            "range": self.range.to_json(),
            "log_scale": self.log_scale,
            "log_scale_sd": self.log_scale_sd,
            "relative_sd": self.relative_sd,
            "shallow_sd": self.shallow_sd,
            "states": [asdict(state) for state in self.states],
            **({} if self.correlation is None else {"correlation": self.correlation}),
        }

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> CalibratedHertz:
        """Return the model with these parameters."""
        states = tuple(StretchState(**state) for state in fields["states"])
        further = {name: fields[name] for name in ("shallow_sd", "log_scale_sd") if name in fields}
        rows = fields.get("correlation")
        correlation = None if rows is None else tuple(map(tuple, rows))
        limits = Range.from_json(fields["range"])
        return cls(
            states,
            fields["log_scale"],
            fields["relative_sd"],
            limits,
            fields["provenance"],
            correlation=correlation,
            **further,
        )


def to_logarithm(stretches: Array, scale: float) -> Array:
    """Return (2, n), the map from moduli at stretches (n,), m, to p and q of the logarithm with this scale, m, by least squares."""
    levels = np.log1p(stretches / scale)
    return np.asarray(np.linalg.pinv(np.column_stack([np.ones_like(levels), levels])))
