"""A lump of dough: its shape, how it lies, and how rolling and pressing change it; a value that never changes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.dough.directions import Directions, directions
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.random import normals

__all__ = ["STEP", "Lump", "Path", "Rolled", "cube"]

Array = npt.NDArray[np.float64]

STEP = 2 * math.pi / 60  # rad of rolling; the fixed grid on which the shape changes
_CENTRED = 20
_FLATTEST = 0.4
_GRID = 1e9  # steps per rad and per newton: coarser than the rounding of a path cut in other places


@dataclass(frozen=True, slots=True)
class Path:
    """The path rolled since the last full step: length, m, the way (x, y), m, and force times length, N m."""

    length: float = 0.0
    x: float = 0.0
    y: float = 0.0
    work: float = 0.0


class Rolled(NamedTuple):
    """The course of full steps of rolling (m,): the height under load, m, and the part of the volume that was missing in each.

    Dough that is displaced is given back; the part missing then is the error of doing so, and the lump is scaled to make up for it.
    """

    heights: Array
    missing: Array


@dataclass(frozen=True, eq=False)
class Lump:
    """Radii (n,), m, from the centroid, the lump turned by `quaternion` (w, x, y, z), its volume, m^3, which it keeps, and its place, m.

    `steps` counts full steps of rolling, and `pending` is the path since; `strain` is the logarithmic height lost in
    presses.
    """

    radii: Array
    quaternion: Array
    volume: float
    x: float = 0.0
    y: float = 0.0
    steps: int = 0
    pending: Path = field(default_factory=Path)
    strain: float = 0.0

    def __post_init__(self) -> None:
        self.radii.flags.writeable = False
        self.quaternion.flags.writeable = False

    @property
    def directions(self) -> Directions:
        """Directions of the radii."""
        return directions(len(self.radii))

    @property
    def ball(self) -> float:
        """Radius of the ball of the same volume, m."""
        return math.cbrt(0.75 * self.volume / math.pi)

    @property
    def roundness(self) -> float:
        """Standard deviation of the radius over its mean, 0 for a ball."""
        return float(self.radii.std() / self.radii.mean())

    @cached_property
    def rotation(self) -> Array:
        """Rotation (3, 3) from its own axes to the world's."""
        w, x, y, z = self.quaternion.tolist()
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    @cached_property
    def upward(self) -> Array:
        """World z of the directions (n,)."""
        return np.asarray(self.directions.vectors @ self.rotation[2])

    @cached_property
    def extent(self) -> tuple[float, float]:
        """How far it reaches below and above its centroid, m."""
        z = self.radii * self.upward
        return float(-z.min()), float(z.max())

    @property
    def height(self) -> float:
        """Height from its lowest to its highest point, m, without a load."""
        low, high = self.extent
        return low + high

    def flattened(self, plastic: float) -> Lump:
        """Return the lump lower by a height, m, for good: its underside is flat and its sides took the volume.

        It lies on another face then, so that the path since its last full step of rolling counts no longer.

        Raises
        ------
        NoEquilibrium
            It would be flatter than four tenths of the diameter of its ball, which a field of radii does not describe.
        """
        from stretch_bt.simulation.dough.roll_kernel import flatten

        if not plastic >= 0:
            raise InvalidInput(f"a press takes at least 0 m of the height, not {plastic}")
        if self.height - plastic < _FLATTEST * 2 * self.ball:
            raise NoEquilibrium(f"a press by {plastic * 1e3:.3g} mm would make a flat disc of the dough")
        radii, found = self.radii.copy(), self.directions
        flatten(radii, self.upward, found.vectors, found.neighbours, found.weights, plastic, self.volume)
        strain = self.strain + math.log(self.height / (self.height - plastic))
        return replace(self, radii=radii, strain=strain, pending=Path())

    def rolled(
        self,
        way: tuple[float, float],
        force: float,
        dough: Dough | None,
        *,
        weight: float = 0.0,
        spin: float = 0.0,
        seed: int = 0,
        rate: float = 0.0,
        step: float = STEP,
    ) -> tuple[Lump, Rolled]:
        """Return the lump after the hand moved straight by (x, y), m, and the course of the full steps.

        It turns by the way over twice the radius of its ball, and goes half of the way. The shape changes on a fixed grid
        of rolled angle, so that the pieces in which a path is given do not matter.

        Parameters
        ----------
        force, weight
            Force of the hand on it and its own weight, N.
        dough
            None for a lump that keeps its shape.
        spin
            How far it turns about the vertical by chance, rad per square root of a rad of rolling.
        rate
            Plastic strain rate, 1/s.
        step
            Rolling between two changes of the shape, rad: one value for all of a path.
        """
        from stretch_bt.simulation.dough.roll_kernel import roll

        ways, pushes, pending = self._steps(way, force, step)
        moved = replace(self, x=self.x + way[0] / 2, y=self.y + way[1] / 2, pending=pending)
        if not len(ways):
            return moved, Rolled(np.empty(0), np.empty(0))
        spins = spin * math.sqrt(step) * normals(seed, self.steps, len(ways)) if spin else np.zeros(len(ways))
        turns = np.column_stack([-ways[:, 1], ways[:, 0], np.zeros(len(ways))]) / (2 * self.ball)
        turns = np.round(turns * _GRID) / _GRID + np.outer(spins, [0.0, 0.0, 1.0])
        loads = np.round(np.column_stack([pushes, pushes + weight]) * _GRID) / _GRID
        radii, quaternion = self.radii.copy(), self.quaternion.copy()
        numbers = np.full(8, math.inf) if dough is None else dough.numbers(rate, step / STEP)
        found = self.directions
        rolled = roll(
            radii, quaternion, found.vectors, found.neighbours, found.weights, turns, loads, self.volume, numbers
        )
        return replace(moved, radii=radii, quaternion=quaternion, steps=self.steps + len(ways)), Rolled(*rolled)

    def _steps(self, way: tuple[float, float], force: float, step: float) -> tuple[Array, Array, Path]:
        """Return the ways (m, 2), m, and forces (m,), N, of the full steps of a straight move, and the path left over."""
        length = math.hypot(*way)
        full = 2 * self.ball * step
        before = self.pending
        # a nanometre of slack: a path of whole steps ends on one, however it is cut
        count = int((before.length + length) / full + 1e-9)
        if count == 0 or length == 0:
            left = Path(
                before.length + length, before.x + way[0], before.y + way[1], before.work + max(force, 0.0) * length
            )
            return np.empty((0, 2)), np.empty(0), left
        along = np.array(way) / length
        first = full - before.length
        ways = np.repeat([along * full], count, axis=0)
        ways[0] = np.array([before.x, before.y]) + along * first
        pushes = np.full(count, max(force, 0.0))
        pushes[0] = (before.work + max(force, 0.0) * first) / full
        rest = before.length + length - count * full
        x, y = along * rest
        return ways, pushes, Path(rest, float(x), float(y), max(force, 0.0) * rest)


def cube(edge: float, count: int = 500, heading: float = 0.0) -> Lump:
    """Return a cube of an edge, m, that lies on a face and is turned by `heading`, rad, about the vertical."""
    if not (math.isfinite(edge) and edge > 0):
        raise InvalidInput(f"the edge of a cube is a finite length above 0 m, not {edge}")
    found = directions(count)
    middle = np.zeros(3)
    for _ in range(_CENTRED):  # radii begin at the centroid of their field, which is not quite the cube's
        radii = ((edge / 2 - np.sign(found.vectors) * middle) / np.maximum(np.abs(found.vectors), 1e-12)).min(axis=1)
        middle += found.solid_angle / (4 * edge**3) * radii**4 @ found.vectors
    radii *= math.cbrt(edge**3 / (np.sum(radii**3) * found.solid_angle / 3))
    return Lump(radii, np.array([math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]), edge**3)
