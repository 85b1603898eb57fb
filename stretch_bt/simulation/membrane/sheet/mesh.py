"""Meshes that are fine where the sheet meets an indenter and grow coarser away from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis, BasisTable

__all__ = ["Mesh", "breakpoints"]

_LARGEST = 14.0  # hundredths of the gauge; larger elements save nothing and spoil the free edge
_SAMPLES = 4001
_MOST_ELEMENTS = 160
_NO_INVERSE, _NO_SPREAD = np.empty((0, 0, 0, 0, 0)), np.empty((0, 0, 0, 0))


@dataclass(frozen=True)
class Mesh:
    """Tensor product of two axes over the unstretched sheet, lengths in its own unit; x across, y between the clamps."""

    x: Axis
    y: Axis

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape (ny, nx, 3) of the control points."""
        return len(self.y.greville), len(self.x.greville), 3

    @cached_property
    def finest(self) -> float:
        """Length of the smallest element."""
        return float(min(np.diff(self.x.breaks).min(), np.diff(self.y.breaks).min()))

    @cached_property
    def strain(self) -> tuple[BasisTable, BasisTable]:
        """Tables at the Gauss points where the sheet strains."""
        return self.x.gauss(2), self.y.gauss(2)

    @cached_property
    def touch(self) -> tuple[BasisTable, BasisTable]:
        """Tables at the Gauss points where it can touch."""
        return self.x.gauss(4), self.y.gauss(4)

    @property
    def held(self) -> bool:
        """Whether the first and last column of control points are clamped too, as the first and last row always are."""
        return False

    @property
    def inverse(self) -> Array:
        """(ey, ex, qy, qx, 5) at the Gauss points of strain: du/dX, dv/dX, du/dY, dv/dY and the area of a unit of u, v.

        (u, v) are the places on the axes and (X, Y) those on the unstretched sheet; no rows where they are the same.
        """
        return _NO_INVERSE

    @property
    def spread(self) -> Array:
        """(ey, ex, qy, qx) at the Gauss points of contact: the area of a unit of u, v; no rows where that is 1."""
        return _NO_SPREAD

    @cached_property
    def rest(self) -> Array:
        """Control points (ny, nx, 2) of the unstretched sheet."""
        return np.stack(np.meshgrid(self.x.greville, self.y.greville), axis=-1)

    @cached_property
    def areas(self) -> Array:
        """Unstretched area (ny, nx) that belongs to each control point."""
        shares = []
        for axis, table in zip((self.y, self.x), reversed(self.touch), strict=True):
            share = np.zeros(len(axis.greville))
            np.add.at(
                share,
                np.arange(axis.elements)[:, None] + np.arange(3),
                np.einsum("eqi,eq->ei", table.value, table.weight),
            )
            shares.append(share)
        return np.outer(*shares)

    def evaluate(self, control: Array, x: Array, y: Array) -> Array:
        """Return the surface (ny', nx', c) over the grid of reference places x (nx',) and y (ny',)."""
        ex, ey = self.x.locate(x), self.y.locate(y)
        bx, by = self.x.basis(ex, x)[0], self.y.basis(ey, y)[0]
        rows = np.einsum("pj,jpxc->pxc", by, np.stack([control[ey + j] for j in range(3)]))
        return np.asarray(np.einsum("qi,ipqc->pqc", bx, np.stack([rows[:, ex + i] for i in range(3)])))


def breakpoints(length: float, zones: Sequence[Zone], growth: float) -> Array:
    """Return rising breakpoints over [-length/2, length/2]; each element is `growth` times its finer neighbour.

    The wanted size is the zone's inside a zone and grows linearly outside; breakpoints share the integral of its
    inverse evenly, so that mirrored zones give mirrored meshes.

    Raises
    ------
    InvalidInput
        The zones ask for more elements than a press can afford.
    """
    s = np.linspace(-length / 2, length / 2, _SAMPLES)
    size = np.full(_SAMPLES, _LARGEST if growth > 1 else min(z.size for z in zones))
    slope = np.log(growth)
    for zone in zones:
        beyond = np.maximum(np.maximum(zone.low - s, s - zone.high), 0)
        size = np.minimum(size, zone.size + slope * beyond)
    density = 1 / size
    total = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)]) * (s[1] - s[0])
    count = int(np.ceil(total[-1] - 1e-9))
    if count > _MOST_ELEMENTS:
        raise InvalidInput(f"this mesh has {count} elements along one side; at most {_MOST_ELEMENTS} are allowed")
    return np.asarray(np.interp(np.arange(count + 1) / count * total[-1], total, s))
