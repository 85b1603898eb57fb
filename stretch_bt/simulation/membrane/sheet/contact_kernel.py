"""Contact of the sheet with rigid bodies at the Gauss points of its elements, compiled.

A body at distance g below a point, with outward normal n = grad g and curvature k = grad grad g, presses with
p = eps (off - g)+ per reference area, the derivative of the penalty eps (off - g)+^2 / 2. Lengths in the sheet's unit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.simulation.membrane.compiled import kernel
from stretch_bt.simulation.membrane.sheet.elastic_kernel import scatter

__all__ = ["add_dyads", "add_force", "bounds", "contact", "gauss_points", "shape_at", "unpack"]


@kernel("void(float64[:,:,::1],float64[:,::1],float64[::1])")
def bounds(control: Any, centres: Any, radii: Any) -> Any:
    """Fill a ball around each element, (e, 3) and (e,); the surface lies in the hull of its control points."""
    nx = control.shape[1] - 2
    for e in range(radii.shape[0]):
        ey, ex = e // nx, e % nx
        for c in range(3):
            centres[e, c] = control[ey + 1, ex + 1, c]
        most = 0.0
        for j in range(3):
            for i in range(3):
                away = 0.0
                for c in range(3):
                    away += (control[ey + j, ex + i, c] - centres[e, c]) ** 2
                most = max(most, away)
        radii[e] = np.sqrt(most)


@kernel("void(float64[:,:,::1],int64[::1],float64[:,:,::1],float64[:,:,::1],float64[:,::1])")
def gauss_points(control: Any, elements: Any, vx: Any, vy: Any, points: Any) -> Any:
    """Fill the places (len(elements) qy qx, 3) of the Gauss points of some elements."""
    nx = control.shape[1] - 2
    count = 0
    for e in elements:
        ey, ex = e // nx, e % nx
        for qy in range(vy.shape[1]):
            for qx in range(vx.shape[1]):
                x = y = z = 0.0
                for j in range(3):
                    for i in range(3):
                        v = vx[ex, qx, i] * vy[ey, qy, j]
                        x += v * control[ey + j, ex + i, 0]
                        y += v * control[ey + j, ex + i, 1]
                        z += v * control[ey + j, ex + i, 2]
                points[count, 0], points[count, 1], points[count, 2] = x, y, z
                count += 1


@kernel()
def add_dyads(six: Any, shape: Any, packed: Any, row: Any) -> Any:
    """Add six (6,) times shape shape' to packed (9, 54): column function b, then 9 k + a."""
    for k in range(6):
        for a in range(9):
            row[9 * k + a] = six[k] * shape[a]
    for b in range(9):
        for r in range(54):
            packed[b, r] += row[r] * shape[b]


@kernel()
def unpack(packed: Any, local: Any) -> Any:
    """Fill local (9, 81), as `scatter` wants it, from the six different components."""
    for b in range(9):
        for a in range(9):
            k = 0
            for c in range(3):
                for d in range(c, 3):
                    local[b, 9 * a + 3 * c + d] = packed[b, 9 * k + a]
                    local[b, 9 * a + 3 * d + c] = packed[b, 9 * k + a]
                    k += 1


@kernel()
def shape_at(vx: Any, vy: Any, shape: Any) -> Any:
    """Fill shape (9,) from the functions (3,) of each axis at a Gauss point."""
    for j in range(3):
        for i in range(3):
            shape[3 * j + i] = vx[i] * vy[j]


@kernel()
def add_force(push: Any, ex: Any, ey: Any, shape: Any, grad: Any) -> Any:
    """Take a force (3,) at a Gauss point off the gradient."""
    for a in range(9):
        for c in range(3):
            grad[ey + a // 3, ex + a % 3, c] -= push[c] * shape[a]


@kernel()
def count(p: Any, weight: Any, push: Any, nz: Any, totals: Any) -> Any:
    """Add a point in contact to totals (7,)."""
    for c in range(3):
        totals[c] += push[c]
    totals[3] += p
    totals[4] += weight
    totals[5] += 1.0
    if nz < 0.01:
        totals[6] += p


@kernel()
def stiffen(k: Any, p: Any, normal: Any, curvature: Any, six: Any) -> Any:
    """Fill six (6,) with k times the dyad of the normal less p times the curvature."""
    i = 0
    for c in range(3):
        for d in range(c, 3):
            six[i] = k * normal[c] * normal[d] - p * curvature[i]
            i += 1


@kernel(
    "float64(int64[::1],float64[::1],float64[:,::1],float64[:,::1],float64,float64,"
    "float64[:,:,::1],float64[:,::1],float64[:,:,::1],float64[:,::1],int64,float64[:,:,::1],"
    "float64[:,::1],float64[::1])"
)
def contact(
    elements: Any,
    gap: Any,
    normal: Any,
    curvature: Any,
    off: Any,
    eps: Any,
    vx: Any,
    wx: Any,
    vy: Any,
    wy: Any,
    mode: Any,
    grad: Any,
    band: Any,
    totals: Any,
) -> Any:
    """Return the contact energy; adds to grad, band, and to totals (7,): force, pressure integral, area, count,
    and the pressure integral where the body faces away from the sheet.

    Where `mode` is PROJECTED the body's curvature is left out.
    """
    ny, nx = grad.shape[0], grad.shape[1]
    shape, push, six, row = np.empty(9), np.empty(3), np.empty(6), np.empty(54)
    packed, local = np.empty((9, 54)), np.empty((9, 81))
    energy, q, points = 0.0, 0, wx.shape[1]
    for e in elements:
        ey, ex = e // (nx - 2), e % (nx - 2)
        touched = False
        for g in range(wy.shape[1] * points):
            depth = off - gap[q]
            if depth > 0.0:
                if mode != 0 and not touched:
                    packed[:] = 0.0
                touched = True
                qy, qx = g // points, g % points
                weight = wx[ex, qx] * wy[ey, qy]
                p = weight * eps * depth
                energy += 0.5 * p * depth
                push[0], push[1], push[2] = p * normal[q, 0], p * normal[q, 1], p * normal[q, 2]
                shape_at(vx[ex, qx], vy[ey, qy], shape)
                add_force(push, ex, ey, shape, grad)
                count(p, weight, push, normal[q, 2], totals)
                if mode != 0:
                    stiffen(weight * eps, p if mode == 1 else 0.0, normal[q], curvature[q], six)
                    add_dyads(six, shape, packed, row)
            q += 1
        if touched and mode != 0:
            unpack(packed, local)
            scatter(local, ex, ey, nx, ny, band)
    return energy
