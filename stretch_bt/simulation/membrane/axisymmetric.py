"""A circular, pre-stretched membrane under a rigid sphere, by shooting: the reference that other solvers are held to.

The equations describe a rotationally symmetric hyperelastic membrane in finite strain (Adkins and Rivlin 1952;
Yang and Feng 1970) for an incompressible material, frictionless contact and no weight.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.membrane.materials import Material
from stretch_bt.simulation.membrane.materials.base import energy, tensions

__all__ = ["AxisymmetricPress", "CircularMembrane"]

Array = npt.NDArray[np.float64]

_FINE, _ROUGH = 1e-12, 1e-7  # relative tolerance of the last shots, and of those that only bracket
_POLE = 1e-5  # integration begins at this part of the contact radius; the series error there is its square
_FIRST_EXCESS = 1e-3
_MOST_RATES = 500_000


@dataclass(frozen=True, slots=True)
class AxisymmetricPress:
    """One equilibrium; SI units.

    `profile` (n, 2) is radius and height, m, from the pole to the clamp, height over the flat membrane. `residual` is
    the larger error of the two end conditions over the clamp radius.
    """

    force: float
    force_error: float
    contact_radius: float
    contact_angle: float
    energy: float
    profile: Array
    residual: float
    iterations: int
    seconds: float

    def height(self, distance: Array) -> Array:
        """Return the height, m, at distances from the axis, m, between the few places of the profile; 0 beyond the clamp."""
        from scipy.interpolate import PchipInterpolator

        known, first = np.unique(self.profile[:, 0], return_index=True)
        known, height = np.append(0.0, known), np.append(self.profile[0, 1], self.profile[first, 1])
        within = PchipInterpolator(known, height)(np.minimum(distance, known[-1]))
        return np.where(distance < known[-1], within, 0.0)


class _Shot(NamedTuple):
    """Where a shot ends: radius, depth and energy at the clamp, force, and contact angle; lengths over the clamp's."""

    radius: float
    depth: float
    energy: float
    force: float
    angle: float
    path: tuple[_Path, ...]


class _Path(NamedTuple):
    """The undeformed radii (n,) of the steps of a shot, the states (5, n) there, and whether it came to its end."""

    places: Array
    states: Array
    arrived: bool


@dataclass(frozen=True, slots=True)
class CircularMembrane:
    """A membrane of undeformed `thickness`, m, clamped at `radius`, m, after an even stretch by `prestretch`."""

    radius: float
    thickness: float
    material: Material
    prestretch: float = 1.0

    def __post_init__(self) -> None:
        for name in ("radius", "thickness", "prestretch"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"the {name} of a circular membrane must be a finite number above 0, not {value!r}")
        if self.prestretch < 1:
            raise InvalidInput(f"the prestretch must be at least 1, not {self.prestretch!r}")

    @classmethod
    def in_place_of(
        cls, width: float, gauge: float, length: float, thickness: float, material: Material
    ) -> CircularMembrane:
        """Return the round membrane that stands in for a sheet pulled to a length, m: of its deformed area, and stretched evenly.

        `width` and `gauge`, m, are of the unstressed sheet, `length` is measured between its clamps. The sheet narrows as a
        strip would, and the even stretch changes an area by as much.
        """
        narrow = width * (gauge / length) ** 0.5
        return cls(math.sqrt(length * narrow / math.pi), thickness, material, (length / gauge) ** 0.25)

    def press(self, sphere_radius: float, depth: float) -> AxisymmetricPress:
        """Return the equilibrium under a frictionless rigid sphere pressed `depth`, m, past the flat membrane.

        Raises
        ------
        NoEquilibrium
            The depth lies past the limit point, or the membrane would wrap past the equator of the sphere.
        """
        if not (0 < sphere_radius < self.radius and math.isfinite(depth) and depth > 0):
            raise InvalidInput(
                f"the sphere must be smaller than the membrane and the depth above 0 m, not {sphere_radius} and {depth}"
            )
        began = time.process_time()
        shooting = _Shooting(self.material, sphere_radius / self.radius, self.prestretch)
        try:
            # a shot that has lost its tension goes nowhere
            with np.errstate(divide="ignore", invalid="ignore"), warnings.catch_warnings():
                warnings.filterwarnings("ignore", "dop853: ", UserWarning)
                shot, residual = shooting.solve(depth / self.radius)
        except (ValueError, ZeroDivisionError, OverflowError):
            raise NoEquilibrium("the shooting lost its way: press deeper or stretch further") from None
        unit = self.material.shear_modulus * self.thickness * self.radius
        profile = shooting.profile(shot) * self.radius
        return AxisymmetricPress(
            shot.force * unit,
            shot.force * unit * max(1e-9, 10 * residual / (depth / self.radius)),
            sphere_radius * math.sin(shot.angle),
            shot.angle,
            shot.energy * unit * self.radius,
            profile,
            residual,
            shooting.shots,
            time.process_time() - began,
        )


class _Shooting:
    """Shoots from the pole with (pole stretch, undeformed contact radius); lengths over the clamp radius."""

    def __init__(self, material: Material, sphere: float, prestretch: float) -> None:
        self.material, self.sphere, self.prestretch = material, sphere, prestretch
        self.end = 1 / prestretch
        self.shots = self.rates = 0

    def solve(self, depth: float) -> tuple[_Shot, float]:
        """March the contact outwards until it is deep enough, then hit both end conditions at once."""
        guess = self._march(depth)
        stretch, edge = self._newton(guess, depth)
        shot = self.shoot(stretch, edge)
        residual = max(abs(shot.radius - 1), abs(shot.depth - depth))
        if residual > 1e-9:
            raise NoEquilibrium(f"the shooting did not meet its end conditions: {residual:.1e} is left")
        if shot.angle > math.pi / 2:
            raise NoEquilibrium("the membrane wraps past the equator of the sphere")
        return shot, residual

    def _march(self, depth: float) -> tuple[float, float]:
        """Return (pole stretch, contact radius) of states of growing pole stretch, interpolated to the depth.

        For a given pole stretch the clamp condition has one contact radius, also without pre-stretch, where a given
        contact radius has several pole stretches.
        """
        excess, edge = _FIRST_EXCESS, 0.05 * self.sphere
        edge, shot = self._fill(excess, edge)
        while shot.depth >= depth:
            excess /= 8
            edge, shot = self._fill(excess, edge)
        while True:
            before = (excess, edge, shot.depth)
            excess *= 2.0 if excess < 0.05 else 1.25
            edge, shot = self._fill(excess, edge)
            if shot.depth >= depth:
                break
            if shot.depth < before[2]:
                raise NoEquilibrium(f"the depth has its limit point near {before[2]:.3g} of the clamp radius")
            if shot.angle > math.pi / 2:
                raise NoEquilibrium("the membrane wraps past the equator of the sphere before this depth")
        part = math.log(depth / before[2]) / math.log(shot.depth / before[2])
        excess = before[0] * (excess / before[0]) ** part
        return self.prestretch * (1 + excess), before[1] * (edge / before[1]) ** part

    def _fill(self, excess: float, edge: float) -> tuple[float, _Shot]:
        """Return the contact radius that brings the rim to the clamp for a pole stretch of (1 + excess) prestretch."""
        from scipy.optimize import brentq

        stretch = self.prestretch * (1 + excess)

        def miss(log_edge: float) -> float:
            shot = self.shoot(stretch, math.exp(log_edge), _ROUGH)
            return shot.radius - 1 if shot.force > 0 and math.isfinite(shot.radius) else -1.0  # tension is lost

        low = high = math.log(edge)
        most = math.log(0.999 * self.end)
        while miss(low) < 0 and low > -50:
            low -= 0.4
        while miss(high) > 0 and high < most:
            high = min(high + 0.4, most)
        if miss(low) < 0 or miss(high) > 0:
            raise NoEquilibrium("the membrane wraps the sphere up to its clamp before this depth")
        found = math.exp(float(brentq(miss, low, high, xtol=1e-4)))
        return found, self.shoot(stretch, found, _ROUGH)

    def _newton(self, guess: tuple[float, float], depth: float) -> tuple[float, float]:
        from scipy.optimize import root

        def miss(v: Array) -> tuple[float, float]:
            shot = self.shoot(float(v[0]), math.exp(float(v[1])))
            return shot.radius - 1, (shot.depth - depth)

        found = root(miss, np.array([guess[0], math.log(guess[1])]), method="hybr", options={"xtol": 1e-13})
        return float(found.x[0]), math.exp(float(found.x[1]))

    def shoot(self, stretch: float, edge: float, rtol: float = _FINE) -> _Shot:
        """Integrate from the pole to the clamp; `edge` is the contact's undeformed radius."""
        self.shots += 1
        first = _POLE * edge
        angle = stretch * first / self.sphere
        state = [stretch, stretch, angle, self.sphere * angle * angle / 2, 0.0]
        touching = self._along(first, edge, state, rtol, contact=True)
        middle = touching.states[:, -1]
        n1 = tensions(self.material, middle[0], middle[1])[0]
        force = 2 * math.pi * edge * n1 * math.sin(middle[2])
        free = self._along(edge, self.end, middle, rtol, contact=False)
        last = free.states[:, -1]
        radius = float(last[1] * self.end) if free.arrived else math.inf
        return _Shot(radius, float(last[3]), float(last[4]), float(force), float(middle[2]), (touching, free))

    def _along(self, begin: float, end: float, state: Sequence[float] | Array, rtol: float, *, contact: bool) -> _Path:
        """Integrate from one undeformed radius to another; the order is 8 (Hairer, Norsett and Wanner, 1993)."""
        from scipy.integrate import ode

        places: list[float] = []
        states: list[Array] = []

        def keep(s: float, at: Array) -> None:
            places.append(s)
            states.append(at.copy())

        def rates(s: float, at: Array) -> list[float]:
            return self._rates(s, at, contact)

        solver: Any = ode(rates)
        solver.set_integrator("dop853", rtol=rtol, atol=rtol / 100, nsteps=_MOST_RATES)
        solver.set_solout(keep)
        solver.set_initial_value(state, begin)
        solver.integrate(end)
        return _Path(np.array(places), np.array(states).T, solver.successful())

    def _rates(self, s: float, state: Array, contact: bool) -> list[float]:
        self.rates += 1
        if self.rates > _MOST_RATES:
            raise NoEquilibrium(
                f"no equilibrium within {_MOST_RATES:,} rates of shooting: press deeper or stretch further"
            )
        l1, l2, angle = float(state[0]), float(state[1]), float(state[2])
        n1, n2, a11, a12 = tensions(self.material, l1, l2)
        cosine, sine = math.cos(angle), math.sin(angle)
        hoop = (l1 * cosine - l2) / s
        turn = l1 / self.sphere if contact else -n2 * sine / (s * n1)
        along = ((n2 * cosine - n1) / s - a12 * hoop) / a11
        return [along, hoop, turn, l1 * sine, 2 * math.pi * s * energy(self.material, l1, l2)]

    def profile(self, shot: _Shot) -> Array:
        """Return (n, 2) radius and height over the flat membrane along a shot."""
        s = np.concatenate([part.places for part in shot.path])
        y = np.concatenate([part.states for part in shot.path], axis=1)
        return np.column_stack([s * y[1], shot.depth - y[3]])
