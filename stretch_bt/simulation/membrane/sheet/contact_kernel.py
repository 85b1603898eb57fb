"""Contact of the sheet with rigid bodies at the Gauss points of its elements, compiled.

A body at distance g below a point, with outward normal n = grad g and curvature k = grad grad g, presses with
p = eps (off - g)+ per reference area, the derivative of the penalty eps (off - g)+^2 / 2. Lengths in the sheet's unit,
lengths of a body in metres. Sums over the nine functions of an element go along x first and then along y.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.membrane.sheet.elastic_kernel import scatter

TIE = 1e-13  # penetration, sheet units, within which a flat face lies on the flat sheet: which points touch would be rounding

__all__ = ["bounds", "contact", "gauss_points", "leftover", "tangents", "within_reach"]


@kernel()
def to_body(x: Any, y: Any, z: Any, unit: Any, origin: Any, rotation: Any, out: Any) -> Any:
    """Fill out (3,), m, with a place given in the sheet's unit as the body sees it."""
    x, y, z = x * unit - origin[0], y * unit - origin[1], z * unit - origin[2]
    for c in range(3):
        out[c] = x * rotation[0, c] + y * rotation[1, c] + z * rotation[2, c]


@kernel("void(float64[:,:,::1],float64,float64[::1],float64[:,::1],float64[:,::1],float64[::1])")
def bounds(control: Any, unit: Any, origin: Any, rotation: Any, centres: Any, radii: Any) -> Any:
    """Fill a ball around each element, (e, 3) and (e,), m, body's frame; the surface lies in the hull of its controls."""
    nx = control.shape[1] - 2
    for e in range(radii.shape[0]):
        ey, ex = e // nx, e % nx
        most = 0.0
        for j in range(3):
            for i in range(3):
                away = 0.0
                for c in range(3):
                    away += (control[ey + j, ex + i, c] - control[ey + 1, ex + 1, c]) ** 2
                most = max(most, away)
        radii[e] = np.sqrt(most) * unit
        middle = control[ey + 1, ex + 1]
        to_body(middle[0], middle[1], middle[2], unit, origin, rotation, centres[e])


@kernel()
def column_places(control: Any, ex: Any, ey: Any, v: Any, columns: Any) -> Any:
    """Fill columns (3, 3) with the places of an element's three columns of control points at one place along y."""
    for i in range(3):
        for c in range(3):
            columns[i, c] = (
                v[0] * control[ey, ex + i, c] + v[1] * control[ey + 1, ex + i, c] + v[2] * control[ey + 2, ex + i, c]
            )


@kernel()
def point_at(u: Any, columns: Any, unit: Any, origin: Any, rotation: Any, point: Any) -> Any:
    """Fill a point (3,), m, body's frame: three functions u (3,) along x times the places of columns (3, 3)."""
    x = u[0] * columns[0, 0] + u[1] * columns[1, 0] + u[2] * columns[2, 0]
    y = u[0] * columns[0, 1] + u[1] * columns[1, 1] + u[2] * columns[2, 1]
    z = u[0] * columns[0, 2] + u[1] * columns[1, 2] + u[2] * columns[2, 2]
    to_body(x, y, z, unit, origin, rotation, point)


@kernel(
    "void(float64[:,:,::1],int64[::1],float64[:,:,::1],float64[:,:,::1],float64,float64[::1],float64[:,::1],"
    "float64[:,::1])"
)
def gauss_points(
    control: Any, elements: Any, vx: Any, vy: Any, unit: Any, origin: Any, rotation: Any, points: Any
) -> Any:
    """Fill the places (len(elements) qy qx, 3), m, body's frame, of the Gauss points of some elements."""
    nx, count, columns = control.shape[1] - 2, 0, np.empty((3, 3))
    for e in elements:
        ey, ex = e // nx, e % nx
        for qy in range(vy.shape[1]):
            column_places(control, ex, ey, vy[ey, qy], columns)
            for qx in range(vx.shape[1]):
                point_at(vx[ex, qx], columns, unit, origin, rotation, points[count])
                count += 1


@kernel(
    "UniTuple(int64,2)(float64[:,:,::1],int64[::1],float64[:,::1],float64[::1],float64[:,:,::1],float64[:,:,::1],float64,float64,"
    "float64[::1],float64[:,::1],float64[:,::1],int64[::1],float64[::1])"
)
def within_reach(
    control: Any,
    elements: Any,
    centres: Any,
    distances: Any,
    vx: Any,
    vy: Any,
    unit: Any,
    reach: Any,
    origin: Any,
    rotation: Any,
    points: Any,
    places: Any,
    least: Any,
) -> Any:
    """Return how many of some elements have a Gauss point that a body may reach, and how many such points there are.

    These elements are moved to the front of `elements`. `centres` (e, 3) and `distances` (e,) are of all elements, m, body's frame. Fills
    `least` with a lower bound of the distance of each point of those elements, `points` (n, 3) with the points within reach, and `places`
    with their numbers among all points of those elements.
    """
    nx, kept, count, columns = control.shape[1] - 2, 0, 0, np.empty((3, 3))
    for k in range(elements.shape[0]):
        e = elements[k]
        ey, ex, before, q = e // nx, e % nx, count, kept * vx.shape[1] * vy.shape[1]
        for qy in range(vy.shape[1]):
            column_places(control, ex, ey, vy[ey, qy], columns)
            for qx in range(vx.shape[1]):
                point_at(vx[ex, qx], columns, unit, origin, rotation, points[count])
                away = 0.0
                for c in range(3):
                    away += (points[count, c] - centres[e, c]) ** 2
                least[q] = distances[e] - np.sqrt(away)
                if least[q] < reach:
                    places[count] = q
                    count += 1
                q += 1
        if count > before:
            elements[kept] = e
            kept += 1
    return kept, count


@kernel()
def add_line(six: Any, v: Any, line: Any) -> Any:
    """Add six (6,) times the products of three functions v (3,) along x to line (9, 6)."""
    for i in range(3):
        for k in range(3):
            product = v[i] * v[k]
            for m in range(6):
                line[3 * i + k, m] += product * six[m]


@kernel()
def add_block(line: Any, v: Any, packed: Any) -> Any:
    """Add a line (9, 6) times the products of three functions v (3,) along y to packed (9, 54), and clear the line."""
    for j in range(3):
        for k in range(j + 1):
            product = v[j] * v[k]
            for m in range(54):
                packed[3 * j + k, m] += product * line[m]
    line[:] = 0.0


@kernel()
def unpack(packed: Any, local: Any) -> Any:
    """Fill local (9, 81), as `scatter` wants it, from packed (9, 54): row 3 j + k, column 6 (3 i + l) + component."""
    for b in range(9):
        for a in range(b, 9):
            m = 6 * (3 * (a % 3) + b % 3)
            row = packed[3 * (a // 3) + b // 3]
            k = 0
            for c in range(3):
                for d in range(c, 3):
                    local[b, 9 * a + 3 * c + d] = row[m + k]
                    local[b, 9 * a + 3 * d + c] = row[m + k]
                    k += 1


@kernel()
def stiffen(k: Any, p: Any, normal: Any, curvature: Any, six: Any) -> Any:
    """Fill six (6,) with k times the dyad of the normal less p times the curvature."""
    m = 0
    for c in range(3):
        for d in range(c, 3):
            six[m] = k * normal[c] * normal[d] - p * curvature[m]
            m += 1


@kernel()
def add_push(push: Any, v: Any, pushes: Any) -> Any:
    """Add a force (3,) times three functions v (3,) along x to pushes (3, 3)."""
    for i in range(3):
        for c in range(3):
            pushes[i, c] += push[c] * v[i]


@kernel()
def take_off(pushes: Any, v: Any, ex: Any, ey: Any, grad: Any) -> Any:
    """Take forces on a line (3, 3) times three functions v (3,) along y off the gradient, and clear them."""
    for j in range(3):
        for i in range(3):
            for c in range(3):
                grad[ey + j, ex + i, c] -= v[j] * pushes[i, c]
    pushes[:] = 0.0


@kernel()
def count(p: Any, weight: Any, push: Any, nz: Any, totals: Any) -> Any:
    """Add a point in contact to totals (8,), but for the energy."""
    for c in range(3):
        totals[c] += push[c]
    totals[3] += p
    totals[4] += weight
    totals[5] += 1.0
    if nz < 0.01:
        totals[6] += p


@kernel(
    "float64(int64[::1],float64[::1],float64[:,::1],float64[:,::1],float64,float64,float64,"
    "float64[:,:,::1],float64[:,::1],float64[:,:,::1],float64[:,::1],float64[:,:,:,::1],int64,float64[:,:,::1],"
    "float64[:,::1],float64[::1])"
)
def contact(
    elements: Any,
    gap: Any,
    normal: Any,
    curvature: Any,
    unit: Any,
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

    `spread` (ey, ex, qy, qx) is Mesh's; it has no rows where the mesh lies on the sheet as it is.
    Where `mode` is PROJECTED the body's curvature is left out.
    """
    ny, nx = grad.shape[0], grad.shape[1]
    push, pushes, six = np.empty(3), np.zeros((3, 3)), np.empty(6)
    line, packed, local = np.zeros(54), np.empty((9, 54)), np.empty((9, 81))
    energy, q, bends = 0.0, 0, unit if mode == 1 else 0.0
    for e in elements:
        ey, ex = e // (nx - 2), e % (nx - 2)
        touched = False
        for qy in range(wy.shape[1]):
            reached = False
            for qx in range(wx.shape[1]):
                depth = off - gap[q] / unit
                if depth > -TIE:
                    if mode != 0 and not touched:
                        packed[:] = 0.0
                    touched = reached = True
                    weight = wx[ex, qx] * wy[ey, qy]
                    if spread.shape[0] > 0:
                        weight *= spread[ey, ex, qy, qx]
                    p = weight * eps * depth
                    energy += 0.5 * p * depth
                    totals[7] += 0.5 * p * depth
                    push[0], push[1], push[2] = p * normal[q, 0], p * normal[q, 1], p * normal[q, 2]
                    count(p, weight, push, normal[q, 2], totals)
                    add_push(push, vx[ex, qx], pushes)
                    if mode != 0:
                        stiffen(weight * eps, bends * p, normal[q], curvature[q], six)
                        add_line(six, vx[ex, qx], line.reshape(9, 6))
                q += 1
            if reached:
                take_off(pushes, vy[ey, qy], ex, ey, grad)
                if mode != 0:
                    add_block(line, vy[ey, qy], packed)
        if touched and mode != 0:
            unpack(packed, local)
            scatter(local, ex, ey, nx, ny, band)
    return energy


@kernel(
    "void(float64[:,:,::1],int64[::1],float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],"
    "float64[:,::1],float64[:,::1])"
)
def tangents(control: Any, elements: Any, vx: Any, sx: Any, vy: Any, sy: Any, along_x: Any, along_y: Any) -> Any:
    """Fill the derivatives of the place by x and by y, (len(elements) qy qx, 3), at the Gauss points of some elements."""
    nx, count = control.shape[1] - 2, 0
    for e in elements:
        ey, ex = e // nx, e % nx
        for qy in range(vy.shape[1]):
            for qx in range(vx.shape[1]):
                for c in range(3):
                    u = v = 0.0
                    for j in range(3):
                        for i in range(3):
                            u += sx[ex, qx, i] * vy[ey, qy, j] * control[ey + j, ex + i, c]
                            v += vx[ex, qx, i] * sy[ey, qy, j] * control[ey + j, ex + i, c]
                    along_x[count, c], along_y[count, c] = u, v
                count += 1


@kernel(
    "void(int64[::1],float64[::1],float64[:,::1],float64[:,::1],float64,float64,float64,float64[:,:,::1],float64[:,::1],"
    "float64[:,:,::1],float64[:,::1],float64[:,:,:,::1],float64[:,:,::1],float64[:,:,:,::1])"
)
def leftover(
    elements: Any,
    gap: Any,
    normal: Any,
    curvature: Any,
    unit: Any,
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
            away = gap[q] / unit
            if off > away:
                weight = eps * wx[ex, qx] * wy[ey, qy]
                if spread.shape[0] > 0:
                    weight *= spread[ey, ex, qy, qx]
                p, k = weight * (off - away) * unit, 0
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
                            push = -weight * away * normal[q, c]
                            excess[ey + j, ex + i, c] += push * vx[ex, qx, i] * vy[ey, qy, j]
            q += 1
