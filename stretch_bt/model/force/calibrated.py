"""The paper's force law: an effective modulus from calibration, then Hertz contact with a sphere."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model.checks import MOST_SD, require_within
from stretch_bt.model.force.force_model import MOST, ForceModel, Range, require_force
from stretch_bt.units import KINDS, format_quantity, is_number

__all__ = ["MOST_SHALLOW", "SHALLOW", "CalibratedHertz", "StretchState"]

SHALLOW = 5e-3  # m; at lesser depths a membrane does not follow the formula of Hertz
MOST_SHALLOW = 100.0  # of `shallow_sd`

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
        """Return E*, Pa, for a diameter, m, and its variance."""
        falling = math.exp(-diameter / self.decay)
        slope = self.amplitude * falling * diameter / self.decay**2
        variance = self.floor_sd**2 + (falling * self.amplitude_sd) ** 2 + (slope * self.decay_sd) ** 2
        return self.floor + self.amplitude * falling, variance


@dataclass(frozen=True)
class CalibratedHertz(ForceModel):
    """The paper's model: E* a negative exponential in diameter at each stretch, a logarithm across stretches.

    E*(x) = p + q ln(1 + x / log_scale) is fitted by least squares to the states' E* at the sphere's diameter; the
    force follows from the Hertz sphere. `relative_sd` is the residual of the law itself, as a part of the force; at depths below
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

    def __post_init__(self) -> None:
        if len({state.stretch for state in self.states}) < 2:
            raise InvalidInput("a calibration needs at least two different stretches, to determine how E* rises")
        require_within("log_scale", self.log_scale, _LEAST_SCALE, _MOST_SCALE)
        require_within("relative_sd", self.relative_sd, 0.0, MOST_SD)
        require_within("shallow_sd", self.shallow_sd, 0.0, MOST_SHALLOW)

    @cached_property
    def _fit(self) -> npt.NDArray[np.float64]:
        """(2, states) float: the linear map from the states' moduli to p and q."""
        levels = np.array([math.log1p(state.stretch / self.log_scale) for state in self.states])
        return np.linalg.pinv(np.column_stack([np.ones_like(levels), levels]))

    @cached_property
    def _columns(self) -> npt.NDArray[np.float64]:
        """(6, states) float: floor, amplitude and decay, and their variances."""
        names = ("floor", "amplitude", "decay")
        sds = [[getattr(state, f"{name}_sd") ** 2 for state in self.states] for name in names]
        return np.array([[getattr(state, name) for state in self.states] for name in names] + sds)

    def _logarithm(self, diameter: float) -> tuple[float, float, npt.NDArray[np.float64]]:
        """Return p and q at a diameter, m, and the variance of each state's modulus, as `StretchState.modulus` has them."""
        floor, amplitude, decay, floor_var, amplitude_var, decay_var = self._columns
        falling = np.exp(-diameter / decay)
        slope = amplitude * falling * diameter / decay**2
        p, q = (self._fit @ (floor + amplitude * falling)).tolist()
        return p, q, floor_var + falling**2 * amplitude_var + slope**2 * decay_var

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
        p, q, variances = self._logarithm(2 * radius)
        level = math.log1p(stretch / self.log_scale)
        weights = self._fit[0] + level * self._fit[1]
        return p + q * level, math.sqrt(float(weights**2 @ variances))

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
        p, q, _ = self._logarithm(2 * radius)
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
            "relative_sd": self.relative_sd,
            "shallow_sd": self.shallow_sd,
            "states": [asdict(state) for state in self.states],
        }

    @classmethod
    def from_json(cls, fields: dict[str, Any]) -> CalibratedHertz:
        """Return the model with these parameters."""
        states = tuple(StretchState(**state) for state in fields["states"])
        limits, shallow = Range.from_json(fields["range"]), fields.get("shallow_sd", 0.0)
        return cls(states, fields["log_scale"], fields["relative_sd"], limits, fields["provenance"], shallow)
