"""The membrane at `axisymmetric` fidelity: a round sheet of the same area and mean stretch, by shooting."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.camera.skin import Grid, RoundBump, Skin
from stretch_bt.simulation.fidelity.base import Array, Place, Pressed
from stretch_bt.simulation.fidelity.between import Between
from stretch_bt.simulation.fidelity.curve import Curve
from stretch_bt.simulation.membrane.axisymmetric import AxisymmetricPress, CircularMembrane
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import Material
from stretch_bt.simulation.objects.response import Law
from stretch_bt.simulation.stats import Stats

__all__ = ["AxisymmetricFidelity"]

_GRID = 121  # points along and across that the profile is sampled at
_KEPT = 256  # presses that are kept
_WIDEST = 0.99  # radius of a ball over the sheet's, up to which those between fixed radii are pressed
_GRAZE = 1e-6  # m; the shape of a touch that is lighter


class AxisymmetricFidelity:
    """A sphere in the middle of a round membrane; where on the sheet it stands moves the shape and not the force."""

    remembers = False
    close = 1e-10

    def __init__(
        self,
        width: float,
        gauge: float,
        thickness: float,
        material: Material,
        mount_prestretch: float,
        stats: Stats | None = None,
    ) -> None:
        self.stats = stats or Stats()
        self.width, self.gauge, self.thickness = width, gauge, thickness
        self.material, self.mount_prestretch = material, mount_prestretch
        self._curves: dict[Any, Curve] = {}
        self._pressed: dict[Any, AxisymmetricPress] = {}

    def law(self, place: Place, state: Any) -> Law:
        """Return the force between solved depths; for a ball whose radius varies, between balls of fixed radii."""
        radius = self._radius(place)
        largest = _WIDEST * self._sheet(place.stretch).radius
        if place.varies and radius <= largest:
            return Between(Sphere(2 * radius), lambda ball: self._curve(ball.diameter / 2, place.stretch), 2 * largest)
        return self._curve(radius, place.stretch)

    def _curve(self, radius: float, stretch: float) -> Curve:
        key = (radius, stretch)
        if key not in self._curves:
            self._curves[key] = Curve(lambda depth: np.array([0.0, 0.0, self._solve(radius, stretch, depth).force]))
        return self._curves[key]

    def press(self, place: Place, depth: float, state: Any) -> Pressed:
        """Return the solved profile."""
        return Pressed(self._grid(place, self._solve(self._radius(place), place.stretch, max(depth, _GRAZE))))

    def force(self, place: Place, depth: float, state: Any) -> Array:
        """Return the force, which has no part across."""
        return np.array([0.0, 0.0, self.law(place, state)(depth)[0]])

    def released(self, state: Any) -> None:
        """Return None: it remembers nothing."""

    def lift(self, place: Place) -> float:
        """Return 0: the membrane has no weight."""
        return 0.0

    def free(self, stretch: float) -> Skin:
        """Return a flat membrane."""
        return RoundBump(None, (0.0, 0.0), self.width, self._length(stretch))

    def _sheet(self, stretch: float) -> CircularMembrane:
        sizes = self.width, self.gauge, self._length(stretch), self.thickness
        return CircularMembrane.in_place_of(*sizes, self.material)

    def _length(self, stretch: float) -> float:
        return self.gauge + self.mount_prestretch + stretch

    def _radius(self, place: Place) -> float:
        if place.tilt != (0.0, 0.0):
            raise NoEquilibrium("axisymmetric fidelity has no answer for a tilted hand")
        if place.form is None or place.form.kind != "sphere":
            raise NoEquilibrium("axisymmetric fidelity takes spheres only; use the sheet")
        return place.form.radius

    def _solve(self, radius: float, stretch: float, depth: float) -> AxisymmetricPress:
        key = (radius, stretch, depth)
        if key not in self._pressed:
            sheet = self._sheet(stretch)
            if radius >= sheet.radius:
                raise NoEquilibrium(
                    f"a radius of {radius * 1e3:.4g} mm is above the round membrane's {sheet.radius * 1e3:.4g} mm; use the sheet"
                )
            with self.stats.timed("solve"):
                self._pressed[key] = sheet.press(radius, depth)
            while len(self._pressed) > _KEPT:
                self._pressed.pop(next(iter(self._pressed)))  # the oldest
        return self._pressed[key]

    def _grid(self, place: Place, solved: AxisymmetricPress) -> Skin:
        """Return the profile around the object on the rectangle of the sheet, which its border holds flat."""
        length = self._length(place.stretch)
        x = np.linspace(-self.width / 2, self.width / 2, _GRID)
        y = np.linspace(-length / 2, length / 2, _GRID)
        points = np.stack([*np.meshgrid(x, y), np.zeros((_GRID, _GRID))], axis=-1)
        away = np.hypot(points[..., 0] - place.at[0], points[..., 1] - place.at[1])
        points[..., 2] = solved.height(away)
        return Grid(points)
