"""The bending stiffness of the sheet: a plate energy that is quadratic in the control points.

D/2 times the integral of |x_,ab|^2 with D = mu H^3/3, the incompressible plate. It does not change under rotations, and
where strains vary slowly the second derivatives of the place are the curvatures of the sheet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis, BasisTable

__all__ = ["BendingMatrices"]

Places = npt.NDArray[np.int64]


@dataclass(frozen=True)
class BendingMatrices:
    """Matrices (n, n) of values, slopes and bends along each axis; `rigidity` D over mu H times the squared unit."""

    rigidity: float
    x: tuple[Array, Array, Array]
    y: tuple[Array, Array, Array]

    @classmethod
    def of(cls, mesh: Mesh, rigidity: float) -> BendingMatrices:
        """Return the bending energy of a mesh."""
        tx, ty = mesh.touch
        return cls(rigidity, _matrices(mesh.x, tx), _matrices(mesh.y, ty))

    def _terms(self) -> tuple[tuple[float, Array, Array], ...]:
        (mx, sx, bx), (my, sy, by) = self.x, self.y
        return (self.rigidity, my, bx), (2 * self.rigidity, sy, sx), (self.rigidity, by, mx)

    def gradient(self, control: Array) -> Array:
        """Return the gradient (ny, nx, 3); the energy is half its product with the control points."""
        parts = np.ascontiguousarray(control.transpose(2, 0, 1))
        terms = (k * (y @ parts @ x.T) for k, y, x in self._terms())
        return np.ascontiguousarray(sum(terms).transpose(1, 2, 0))  # type: ignore[union-attr]

    def add(self, band: Array) -> None:
        """Add the Hessian of the unclamped rows to a lower band (n, width)."""
        rows, columns, values = self._hessian
        band[rows, columns] += values

    @cached_property
    def _hessian(self) -> tuple[Places, Places, Array]:
        """Rows, columns and values (m,) in a lower band; each place once."""
        ny, nx = len(self.y[0]), len(self.x[0])
        cells = np.arange((ny - 2) * nx).reshape(ny - 2, nx)
        found: list[tuple[Places, Places, Array]] = []
        for down in range(3):
            for right in range(-2 if down else 0, 3):
                rows, columns = slice(1, ny - 1 - down), slice(max(0, -right), nx - max(0, right))
                j, i = np.arange(ny)[rows], np.arange(nx)[columns]
                value = sum(k * y[j, j + down][:, None] * x[i, i + right] for k, y, x in self._terms())
                target = 3 * cells[: len(j), columns].ravel()
                column = np.full(target.shape, 3 * (down * nx + right))
                found += [(target + c, column, np.asarray(value).ravel()) for c in range(3)]
        rows_, columns_, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return rows_, columns_, values


def _matrices(axis: Axis, table: BasisTable) -> tuple[Array, Array, Array]:
    count = len(axis.greville)
    made = []
    for basis in (table.value, table.slope, table.bend):
        full = np.zeros((count, count))
        for e in range(axis.elements):
            full[e : e + 3, e : e + 3] += (basis[e] * table.weight[e][:, None]).T @ basis[e]
        made.append(full)
    return made[0], made[1], made[2]
