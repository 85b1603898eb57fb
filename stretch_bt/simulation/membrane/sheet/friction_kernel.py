"""Coulomb friction of the sheet at its Gauss points, as an energy that the tractions are the gradient of; compiled.

With the slip u, tangential, since the anchor, the traction is k u as long as that is below the limit L = mu p, and L
along u beyond: the gradient of k u^2 / 2, and of L (u - L / (2 k)). With limit and normal held during a solve the
energy is convex and its Hessian symmetric (lagged friction: Li et al. 2020, Incremental Potential Contact, sec. 5).
Lengths in the sheet's unit. Fields lie over the grid of all Gauss points, (NY, NX, ...), which is the grid of the elements
times four.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.membrane.sheet.contact_kernel import (
    add_block,
    add_line,
    add_push,
    column_places,
    take_off,
    unpack,
)
from stretch_bt.simulation.membrane.sheet.elastic_kernel import scatter

__all__ = ["friction", "tractions"]


@kernel()
def slipped(place: Any, anchor: Any, normal: Any, slip: Any) -> Any:
    """Fill slip (3,) with the tangential way from anchor to place; return its length."""
    across = 0.0
    for c in range(3):
        slip[c] = place[c] - anchor[c]
        across += slip[c] * normal[c]
    length = 0.0
    for c in range(3):
        slip[c] -= across * normal[c]
        length += slip[c] * slip[c]
    return np.sqrt(length)


@kernel()
def resist(slip: Any, length: Any, normal: Any, k: Any, limit: Any, push: Any, six: Any) -> Any:
    """Fill the traction push (3,) against a slip, and its stiffness six (6,); return the energy."""
    slides = k * length > limit
    rate = limit / length if slides else k
    ease = rate / (length * length) if slides else 0.0
    i = 0
    for c in range(3):
        push[c] = -rate * slip[c]
        for d in range(c, 3):
            six[i] = -rate * normal[c] * normal[d] - ease * slip[c] * slip[d]
            if c == d:
                six[i] += rate
            i += 1
    return limit * (length - 0.5 * limit / k) if slides else 0.5 * k * length * length


@kernel(
    "float64(int64[::1],float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,::1],float64,"
    "float64[:,:,::1],float64[:,::1],float64[:,:,::1],float64[:,::1],int64,float64[:,:,::1],"
    "float64[:,::1],float64[::1])"
)
def friction(
    elements: Any,
    control: Any,
    anchor: Any,
    normal: Any,
    limit: Any,
    k: Any,
    vx: Any,
    wx: Any,
    vy: Any,
    wy: Any,
    mode: Any,
    grad: Any,
    band: Any,
    totals: Any,
) -> Any:
    """Return the energy of friction in some elements; adds to grad, band, and the force to totals[:3].

    It acts wherever `limit` is above 0, whether the sheet touches there at this instant or not: the energy must not
    jump while a solve seeks its minimum.
    """
    ny, nx, points = control.shape[0], control.shape[1], wx.shape[1]
    push, pushes, six, columns = np.empty(3), np.zeros((3, 3)), np.empty(6), np.empty((3, 3))
    place, slip = np.empty(3), np.empty(3)
    line, packed, local = np.zeros(54), np.empty((9, 54)), np.empty((9, 81))
    energy = 0.0
    for e in elements:
        ey, ex = e // (nx - 2), e % (nx - 2)
        if mode != 0:
            packed[:] = 0.0
        for qy in range(points):
            r = ey * points + qy
            column_places(control, ex, ey, vy[ey, qy], columns)
            for qx in range(points):
                s = ex * points + qx
                if limit[r, s] > 0.0:
                    for c in range(3):
                        place[c] = (
                            vx[ex, qx, 0] * columns[0, c]
                            + vx[ex, qx, 1] * columns[1, c]
                            + vx[ex, qx, 2] * columns[2, c]
                        )
                    length = slipped(place, anchor[r, s], normal[r, s], slip)
                    weight = wx[ex, qx] * wy[ey, qy]
                    energy += weight * resist(slip, length, normal[r, s], k, limit[r, s], push, six)
                    for c in range(3):
                        push[c] *= weight
                        totals[c] += push[c]
                    add_push(push, vx[ex, qx], pushes)
                    if mode != 0:
                        six *= weight
                        add_line(six, vx[ex, qx], line.reshape(9, 6))
            take_off(pushes, vy[ey, qy], ex, ey, grad)
            if mode != 0:
                add_block(line, vy[ey, qy], packed)
        if mode != 0:
            unpack(packed, local)
            scatter(local, ex, ey, nx, ny, band)
    return energy


@kernel("void(float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,::1],float64,float64[:,:,::1])")
def tractions(places: Any, anchor: Any, normal: Any, limit: Any, k: Any, out: Any) -> Any:
    """Fill out (NY, NX, 3) with the traction on the sheet at its places, per reference area."""
    slip, push, six = np.empty(3), np.empty(3), np.empty(6)
    for r in range(limit.shape[0]):
        for s in range(limit.shape[1]):
            out[r, s] = 0.0
            if limit[r, s] > 0.0:
                length = slipped(places[r, s], anchor[r, s], normal[r, s], slip)
                resist(slip, length, normal[r, s], k, limit[r, s], push, six)
                out[r, s] = push
