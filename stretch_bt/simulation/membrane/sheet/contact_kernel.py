"""Contact of the sheet with rigid bodies at the Gauss points of its elements, compiled.

A body at distance g below a point, with outward normal n = grad g and curvature k = grad grad g, presses with
p = eps (off - g)+ per reference area, the derivative of the penalty eps (off - g)+^2 / 2. Lengths in the sheet's unit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.simulation.membrane.compiled import kernel
from stretch_bt.simulation.membrane.sheet.elastic_kernel import scatter

__all__ = ["bounds", "contact", "gauss_points", "leftover"]


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


@kernel(
    "float64(int64[::1],float64[::1],float64[:,::1],float64[:,::1],float64[:,::1],float64,float64,"
    "float64[:,:,::1],float64[:,::1],float64[:,:,::1],float64[:,::1],float64[:,:,:,::1],int64,float64[:,:,::1],"
    "float64[:,::1],float64[::1])"
)
def contact(
    elements: Any,
    gap: Any,
    normal: Any,
    curvature: Any,
    friction: Any,
    off: Any,
    eps: Any,
    vx: Any,
    wx: Any,
    vy: Any,
    wy: Any,
    spread: Any,
    mode: Any,
    grad: Any,
    band: Any,
    totals: Any,
) -> Any:
    """Return the contact energy; adds to grad, band, and to totals (8,): force, pressure integral, area, count,
    the pressure integral where the body faces away from the sheet, and the energy of the penalty.

    `spread` (ey, ex, qy, qx) is that of Mesh; it has no rows where the mesh lies on the sheet as it is.
    `friction` (q, 10) holds energy, gradient (3,) and Hessian (6: xx, xy, xz, yy, yz, zz) per reference area of the
    points in contact, or has no rows. Where `mode` is PROJECTED the body's curvature is left out.
    """
    ny, nx = grad.shape[0], grad.shape[1]
    shape, six, row = np.empty(9), np.empty(6), np.empty(54)
    packed, local = np.empty((9, 54)), np.empty((9, 81))
    energy, q, rubs = 0.0, 0, friction.shape[0] > 0
    for e in elements:
        ey, ex = e // (nx - 2), e % (nx - 2)
        touched = False
        for g in range(wy.shape[1] * wx.shape[1]):
            qy, qx = g // wx.shape[1], g % wx.shape[1]
            depth = off - gap[q]
            if depth > 0.0:
                if mode != 0 and not touched:
                    packed[:] = 0.0
                touched = True
                weight = wx[ex, qx] * wy[ey, qy]
                if spread.shape[0] > 0:
                    weight *= spread[ey, ex, qy, qx]
                p = weight * eps * depth
                energy += 0.5 * p * depth
                totals[3] += p
                totals[4] += weight
                totals[5] += 1.0
                totals[7] += 0.5 * p * depth
                if normal[q, 2] < 0.01:
                    totals[6] += p
                for j in range(3):
                    for i in range(3):
                        shape[3 * j + i] = vx[ex, qx, i] * vy[ey, qy, j]
                if rubs:
                    energy += weight * friction[q, 0]
                for c in range(3):
                    push = p * normal[q, c]
                    if rubs:
                        push -= weight * friction[q, 1 + c]
                    totals[c] += push
                    for a in range(9):
                        grad[ey + a // 3, ex + a % 3, c] -= push * shape[a]
                if mode != 0:
                    k = 0
                    for c in range(3):
                        for d in range(c, 3):
                            six[k] = weight * eps * normal[q, c] * normal[q, d]
                            if mode == 1:
                                six[k] -= p * curvature[q, k]
                            if rubs:
                                six[k] += weight * friction[q, 4 + k]
                            k += 1
                    add_dyads(six, shape, packed, row)
            q += 1
        if touched and mode != 0:
            unpack(packed, local)
            scatter(local, ex, ey, nx, ny, band)
    return energy


@kernel(
    "void(int64[::1],float64[::1],float64[:,::1],float64[:,::1],float64,float64,float64[:,:,::1],float64[:,::1],"
    "float64[:,:,::1],float64[:,::1],float64[:,:,:,::1],float64[:,:,::1],float64[:,:,:,::1])"
)
def leftover(
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
    spread: Any,
    excess: Any,
    lift: Any,
) -> Any:
    """Add the nodal forces of eps times the penetration left over to excess (ny, nx, 3), and to lift (3, ny, nx, 3) the
    change of the contact's nodal forces as the body moves along x, y or z.
    """
    nx = excess.shape[1] - 2
    q = 0
    for e in elements:
        ey, ex = e // nx, e % nx
        for g in range(wy.shape[1] * wx.shape[1]):
            qy, qx = g // wx.shape[1], g % wx.shape[1]
            if off > gap[q]:
                weight = eps * wx[ex, qx] * wy[ey, qy]
                if spread.shape[0] > 0:
                    weight *= spread[ey, ex, qy, qx]
                p, k = weight * (off - gap[q]), 0
                for c in range(3):
                    for d in range(c, 3):
                        stiff = weight * normal[q, c] * normal[q, d] - p * curvature[q, k]
                        k += 1
                        for j in range(3):
                            for i in range(3):
                                share = vx[ex, qx, i] * vy[ey, qy, j] * stiff
                                lift[c, ey + j, ex + i, d] += share
                                if c != d:
                                    lift[d, ey + j, ex + i, c] += share
                    for j in range(3):
                        for i in range(3):
                            push = -weight * gap[q] * normal[q, c]
                            excess[ey + j, ex + i, c] += push * vx[ex, qx, i] * vy[ey, qy, j]
            q += 1
