"""Material points of an elastic-plastic body between a table and a hand, compiled.

Moving-least-squares transfers with quadratic splines (Hu et al. 2018) and an affine velocity field per point (Jiang et al.
2015); neo-Hookean with a von Mises yield stress by the radial return of Simo (1988), whose left strain stays isochoric.

Table and hand press on points and not on nodes, so that neither leaps from one layer of the grid to the next: in
proportion to how far a point is past them, with Coulomb friction towards their own motion. A hand that is a soft foundation
presses with `foundation` times the volume above its line, which has the resultant of pressing with depth times
`foundation` all over its surface.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mpm.law import (
    BULK,
    DENSITY,
    DT,
    DX,
    GRAVITY,
    HAND,
    MARGIN,
    SHEAR,
    TABLE,
    VOLUME,
    YIELD,
    returned,
    rubbed,
    spline,
    strained,
)
from stretch_bt.compiled import kernel

__all__ = ["advance"]

_FREE = 2  # nodes around the body
_RUSH = 0.3  # m/s at which the hand goes up or down at most to keep its force


@kernel("boolean(float64[:,::1], int64[::1], float64, int64)")
def framed(places: Any, base: Any, dx: Any, size: Any) -> Any:
    """Fill `base` (3,) with the corner of a grid that holds all points; return whether a grid of `size` nodes a side does."""
    for c in range(3):
        low, high = places[0, c], places[0, c]
        for i in range(len(places)):
            low, high = min(low, places[i, c]), max(high, places[i, c])
        base[c] = math.floor(low / dx) - _FREE
        if not high / dx + _FREE < base[c] + size:
            return False
    return True


@kernel(
    "UniTuple(float64, 2)(float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,::1], float64[::1], float64, boolean, float64[::1])"
)
def loaded(places: Any, speeds: Any, crept: Any, impulses: Any, way: Any, line: Any, soft: Any, numbers: Any) -> Any:
    """Fill `impulses` (n, 3), N s, with the impulses of table, hand and weight; return the hand's force, N, and its slope, N/m."""
    dt, side = numbers[DT], numbers[VOLUME] ** (1.0 / 3.0)
    mass = numbers[VOLUME] * numbers[DENSITY]
    total, steep = 0.0, 0.0
    for i in range(len(places)):
        push = numbers[TABLE] * max(numbers[MARGIN] - places[i, 2], 0.0)
        x, y = rubbed(crept[i, 0], push, speeds[i, 0], speeds[i, 1], numbers)
        z = push * dt - mass * numbers[GRAVITY] * dt
        if soft:
            part = min(max((places[i, 2] - line) / side + 0.5, 0.0), 1.0)
            push = numbers[HAND] * numbers[VOLUME] * part
            steep += numbers[HAND] * numbers[VOLUME] / side if 0.0 < part < 1.0 else 0.0
        else:
            push = numbers[HAND] * max(places[i, 2] + numbers[MARGIN] - line, 0.0)
            steep += numbers[HAND] if push > 0.0 else 0.0
        dragged = rubbed(crept[i, 1], push, speeds[i, 0] - way[0], speeds[i, 1] - way[1], numbers)
        impulses[i, 0], impulses[i, 1], impulses[i, 2] = x + dragged[0], y + dragged[1], z - push * dt
        total += push
    return total, steep


@kernel(
    "void(float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,::1], float64[::1], float64[:,::1],"
    " float64[:,:,:,::1], int64[::1], float64[::1])"
)
def scatter(
    places: Any,
    speeds: Any,
    affine: Any,
    strains: Any,
    contents: Any,
    impulses: Any,
    grid: Any,
    base: Any,
    numbers: Any,
) -> None:
    """Give momentum, with a step's impulses and stresses, and mass of all points to the nodes."""
    dx = numbers[DX]
    mass = numbers[VOLUME] * numbers[DENSITY]
    gain = -numbers[DT] * numbers[VOLUME] * 4.0 / dx**2
    shear = gain * numbers[SHEAR]
    for i in range(len(places)):
        third = (strains[i, 0] + strains[i, 1] + strains[i, 2]) / 3.0
        even = gain * 0.5 * numbers[BULK] * (contents[i] ** 2 - 1.0) - shear * third
        xy, xz, yz = shear * strains[i, 3], shear * strains[i, 4], shear * strains[i, 5]
        q00 = even + shear * strains[i, 0] + mass * affine[i, 0, 0]
        q11 = even + shear * strains[i, 1] + mass * affine[i, 1, 1]
        q22 = even + shear * strains[i, 2] + mass * affine[i, 2, 2]
        q01, q10 = xy + mass * affine[i, 0, 1], xy + mass * affine[i, 1, 0]
        q02, q20 = xz + mass * affine[i, 0, 2], xz + mass * affine[i, 2, 0]
        q12, q21 = yz + mass * affine[i, 1, 2], yz + mass * affine[i, 2, 1]
        x, y, z = (
            mass * speeds[i, 0] + impulses[i, 0],
            mass * speeds[i, 1] + impulses[i, 1],
            mass * speeds[i, 2] + impulses[i, 2],
        )
        j, fx, u0, u1, u2 = spline(places[i, 0] / dx)
        k, fy, v0, v1, v2 = spline(places[i, 1] / dx)
        m, fz, w0, w1, w2 = spline(places[i, 2] / dx)
        j, k, m = j - base[0], k - base[1], m - base[2]
        for a in range(3):
            da = (a - fx) * dx
            wa = u0 if a == 0 else (u1 if a == 1 else u2)
            for b in range(3):
                db = (b - fy) * dx
                wab = wa * (v0 if b == 0 else (v1 if b == 1 else v2))
                ax, ay, az = x + q00 * da + q01 * db, y + q10 * da + q11 * db, z + q20 * da + q21 * db
                for c in range(3):
                    dc = (c - fz) * dx
                    weight = wab * (w0 if c == 0 else (w1 if c == 1 else w2))
                    grid[j + a, k + b, m + c, 0] += weight * (ax + q02 * dc)
                    grid[j + a, k + b, m + c, 1] += weight * (ay + q12 * dc)
                    grid[j + a, k + b, m + c, 2] += weight * (az + q22 * dc)
                    grid[j + a, k + b, m + c, 3] += weight * mass


@kernel(
    "void(float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,::1], float64[::1], float64[::1],"
    " float64[:,:,:,::1], int64[::1], float64[::1])"
)
def gather(
    places: Any, speeds: Any, affine: Any, strains: Any, contents: Any, slid: Any, grid: Any, base: Any, numbers: Any
) -> None:
    """Take the nodes' velocity to the points, move and strain them; what is past the yield stress stays."""
    dx, dt = numbers[DX], numbers[DT]
    limit = math.sqrt(2.0 / 3.0) * numbers[YIELD] / numbers[SHEAR]
    g = np.empty((3, 3))
    for i in range(len(places)):
        j, fx, u0, u1, u2 = spline(places[i, 0] / dx)
        k, fy, v0, v1, v2 = spline(places[i, 1] / dx)
        m, fz, w0, w1, w2 = spline(places[i, 2] / dx)
        j, k, m = j - base[0], k - base[1], m - base[2]
        sx, sy, sz = 0.0, 0.0, 0.0
        g[:] = 0.0
        for a in range(3):
            wa = u0 if a == 0 else (u1 if a == 1 else u2)
            for b in range(3):
                wab = wa * (v0 if b == 0 else (v1 if b == 1 else v2))
                for c in range(3):
                    weight = wab * (w0 if c == 0 else (w1 if c == 1 else w2))
                    x, y, z = (
                        weight * grid[j + a, k + b, m + c, 0],
                        weight * grid[j + a, k + b, m + c, 1],
                        weight * grid[j + a, k + b, m + c, 2],
                    )
                    sx, sy, sz = sx + x, sy + y, sz + z
                    da, db, dc = a - fx, b - fy, c - fz
                    g[0, 0] += x * da
                    g[0, 1] += x * db
                    g[0, 2] += x * dc
                    g[1, 0] += y * da
                    g[1, 1] += y * db
                    g[1, 2] += y * dc
                    g[2, 0] += z * da
                    g[2, 1] += z * db
                    g[2, 2] += z * dc
        speeds[i, 0], speeds[i, 1], speeds[i, 2] = sx, sy, sz
        for a in range(3):
            places[i, a] += dt * speeds[i, a]
            for b in range(3):
                affine[i, a, b] = 4.0 / dx * g[a, b]
                g[a, b] = dt * affine[i, a, b] + (1.0 if a == b else 0.0)
        grown = (
            g[0, 0] * (g[1, 1] * g[2, 2] - g[1, 2] * g[2, 1])
            - g[0, 1] * (g[1, 0] * g[2, 2] - g[1, 2] * g[2, 0])
            + g[0, 2] * (g[1, 0] * g[2, 1] - g[1, 1] * g[2, 0])
        )
        contents[i] *= grown
        slid[i] += math.sqrt(1.0 / 6.0) * returned(strains[i], strained(g, strains[i], grown), limit)


@kernel(
    "boolean(float64[:,::1], float64[:,::1], float64[:,:,::1], float64[:,::1], float64[::1], float64[::1], float64[:,:,::1],"
    " float64[:,:,:,::1], float64[:,::1], float64[::1], float64, float64[::1], boolean, float64[::1])"
)
def advance(
    places: Any,
    speeds: Any,
    affine: Any,
    strains: Any,
    contents: Any,
    slid: Any,
    crept: Any,
    grid: Any,
    ways: Any,
    forces: Any,
    fall: Any,
    hand: Any,
    soft: Any,
    numbers: Any,
) -> Any:
    """Take all points through as many steps as `ways` (m, 2), m/s, has; return whether the body stayed on the grid.

    Parameters
    ----------
    places, speeds : (n, 3)
    affine : (n, 3, 3)
        Velocity gradient around each point, 1/s.
    strains : (n, 6)
        Isochoric elastic left strain.
    contents, slid : (n,)
        Volume over what it was, and plastic strain so far.
    crept : (n, 2, 2)
        How far each point slipped, m, since it met the table, and the hand.
    grid : (k, k, k, 4)
        Room for momentum and mass of the nodes.
    ways, forces : (m, 2), (m,)
        Velocity of the hand across, m/s, and force that it keeps, N.
    fall : float
        Above 0 the hand comes down at this speed, m/s, whatever the force.
    hand : (2,)
        Its height, m, and its force at the last step, N; changed in place.
    soft : bool
        Whether it is a foundation, to which all volume above its height counts, or a plate.
    """
    dt, side = numbers[DT], numbers[VOLUME] ** (1.0 / 3.0)
    base, impulses = np.empty(3, np.int64), np.empty((len(places), 3))
    least = 1e-3 * numbers[HAND] * side**2 if soft else 1e-3 * numbers[HAND]
    for step in range(len(ways)):
        if not framed(places, base, numbers[DX], grid.shape[0]):
            return False
        grid[:] = 0.0
        force, steep = loaded(places, speeds, crept, impulses, ways[step], hand[0], soft, numbers)
        scatter(places, speeds, affine, strains, contents, impulses, grid, base, numbers)
        for j in range(grid.shape[0]):
            for k in range(grid.shape[1]):
                for m in range(grid.shape[2]):
                    if grid[j, k, m, 3] > 0.0:
                        for c in range(3):
                            grid[j, k, m, c] /= grid[j, k, m, 3]
        gather(places, speeds, affine, strains, contents, slid, grid, base, numbers)
        hand[1] = force
        # a tenth of what is missing, so that the hand does not ring with the points that it meets one after another
        move = 0.1 * (force - forces[step]) / max(steep, least)
        hand[0] += -fall * dt if fall > 0.0 else min(max(move, -_RUSH * dt), _RUSH * dt)
    return True
