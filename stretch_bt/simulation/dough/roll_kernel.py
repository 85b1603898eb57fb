"""The change of a lump as it rolls under the hand or is pressed, step by step, compiled.

The lump is the star-shaped body |p| <= r(d) about its centroid, r (n,) on directions d (n, 3) of equal solid angle w. A
plane at height -h under it cuts an area A(h), the sum of w h^2 / |u|^3 over the directions that reach below it, u being
the upward part of d: the derivative of the volume below the plane. `dough` (8,) holds Dough.numbers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.dough.centre_kernel import SMALLEST, centre, rescale, volume
from stretch_bt.simulation.dough.law_kernel import FOUNDATION, MODULUS, RELAXATION, TENSION, YIELD, flow

__all__ = ["flatten", "roll"]

_RIM = 0.6  # height above the plane, over the mean radius, of the ring that takes half of the displaced volume
_DEEPEST = 0.25  # largest depth of a step over the mean radius
_PASS = 0.02  # largest loss by smoothing or by one pass of a press, over the mean radius
_SHARES = 10  # how often the volume pressed away is given to the sides, where the plates cut some off again
_HALVINGS = 30


@kernel("void(float64[:,::1], float64[::1], float64[::1])")
def upward(vectors: Any, quaternion: Any, u: Any) -> None:
    """Fill u (n,) with the world z of the directions of a lump that is turned by a quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    for i in range(len(u)):
        u[i] = vectors[i, 0] * zx + vectors[i, 1] * zy + vectors[i, 2] * zz


@kernel("UniTuple(float64, 2)(float64[::1], float64[::1])")
def extent(radii: Any, u: Any) -> Any:
    """Return how far the lump reaches below and above its centroid, m."""
    low, high = 0.0, 0.0
    for i in range(len(u)):
        z = radii[i] * u[i]
        low, high = max(low, -z), max(high, z)
    return low, high


@kernel("float64(float64[::1], float64[::1], float64, float64)")
def section(below: Any, weights: Any, h: Any, soft: Any) -> Any:
    """Return the area, m^2, of the section at -h through points that reach `below`, m; `soft` below it one counts fully."""
    area = 0.0
    for i in range(len(below)):
        over = below[i] - h
        if over > 0.0:
            area += weights[i] * min(over / soft, 1.0)
    return area * h * h


@kernel("UniTuple(float64[::1], 2)(float64[::1], float64[::1], float64, float64)")
def lowest(radii: Any, u: Any, w: Any, h: Any) -> Any:
    """Return how far points reach down, m, and w / |u|^3, for points that reach below -h."""
    below, weights = np.empty(len(u)), np.empty(len(u))
    count = 0
    for i in range(len(u)):
        if -radii[i] * u[i] > h:
            below[count], weights[count] = -radii[i] * u[i], w / (-u[i] * u[i] * u[i])
            count += 1
    return below[:count].copy(), weights[:count].copy()


@kernel("UniTuple(float64, 2)(float64[::1], float64[::1], float64, float64, float64, float64, float64, float64[::1])")
def sink(radii: Any, u: Any, w: Any, content: Any, low: Any, tall: Any, force: Any, dough: Any) -> Any:
    """Return how deep the lump sinks on a plane under a force, N, and the plastic part of that, m; a quarter radius at most."""
    ball = (0.75 * content / math.pi) ** (1.0 / 3.0)
    soft = ball * w / (2.0 * math.pi)
    least, most = 0.0, min(_DEEPEST * ball, 0.75 * low)
    below, weights = lowest(radii, u, w, low - most)
    for _ in range(_HALVINGS):
        deep = 0.5 * (least + most)
        if flow(section(below, weights, low - deep, soft), content, tall, deep, dough)[1] < force:
            least = deep
        else:
            most = deep
    area = flow(section(below, weights, low - most, soft), content, tall, most, dough)[0]
    if area <= 0.0:
        return 0.0, 0.0
    return most, max(most - force / (2.0 * dough[MODULUS] * math.sqrt(area / math.pi)), 0.0)


@kernel("float64(float64[::1], float64[::1], float64, float64, float64, float64)")
def waterline(radii: Any, u: Any, w: Any, high: Any, force: Any, foundation: Any) -> Any:
    """Return the height, m, over the centroid above which the lump stands in the hand: foundation x volume = force.

    The volume above a height is convex in it, so that Newton's method approaches from below.
    """
    reach, cubes, steep = np.empty(len(u)), np.empty(len(u)), np.empty(len(u))
    count = 0
    for i in range(len(u)):
        if u[i] > 1e-3:
            reach[count], cubes[count], steep[count] = radii[i] * u[i], radii[i] ** 3, 1.0 / (u[i] * u[i] * u[i])
            count += 1
    line, aim = 0.05 * high, 3.0 * force / (foundation * w)
    for _ in range(_HALVINGS):
        above, area, cube = 0.0, 0.0, line * line * line
        for i in range(count):
            if reach[i] > line:
                above += cubes[i] - cube * steep[i]
                area += steep[i]
        if above <= (1.0 + 1e-6) * aim:
            break
        line = min(line + (above - aim) / (3.0 * line * line * area), high)
    return line


@kernel("UniTuple(float64, 2)(float64[::1], int64[:,::1], float64[:,:,::1], int64)")
def bend(radii: Any, neighbours: Any, weights: Any, i: Any) -> Any:
    """Return the sum of the principal curvatures at a direction times its radius, and how fast it falls with log r.

    The surface is r = exp(f), with f differentiated by the weights; its mean curvature is taken as a graph's over the sphere.
    """
    gu, gv, spread, stiff = 0.0, 0.0, 0.0, 0.0
    inverse = 1.0 / radii[i]
    for k in range(neighbours.shape[1]):
        part = (radii[neighbours[i, k]] - radii[i]) * inverse
        rise = part * (1.0 - part * (0.5 - part / 3.0))  # of the logarithm
        gu += weights[i, k, 0] * rise
        gv += weights[i, k, 1] * rise
        spread += weights[i, k, 2] * rise
        stiff += weights[i, k, 2]
    g = 1.0 + gu * gu + gv * gv
    return (2.0 - spread / g) / math.sqrt(g), stiff


@kernel("void(float64[::1], float64[::1], int64[:,::1], float64[:,:,::1], float64, float64, float64[::1])")
def smooth(radii: Any, u: Any, neighbours: Any, weights: Any, line: Any, ball: Any, dough: Any) -> None:
    """Move points under the membrane inwards where foundation and tension press harder than 2 Y.

    A part of the step after which the excess would be gone is taken, so that none goes past it.
    """
    before = radii.copy()
    for i in range(len(u)):
        over = before[i] * u[i] - line
        if over <= 0.0:
            continue
        bent, stiff = bend(before, neighbours, weights, i)
        excess = dough[FOUNDATION] * over + dough[TENSION] * bent / before[i] - 2.0 * dough[YIELD]
        if excess > 0.0:
            step = dough[RELAXATION] * excess * before[i] ** 2 / (dough[TENSION] * stiff)
            radii[i] -= min(step, _PASS * ball)


@kernel("void(float64[::1], float64[::1], float64, float64, float64, float64)")
def give_back(radii: Any, u: Any, w: Any, content: Any, plane: Any, ball: Any) -> None:
    """Give half of the displaced volume to the points beside the contact with a plane at -plane, and the rest to all alike."""
    area = 0.0
    for i in range(len(u)):
        below = -radii[i] * u[i]
        if plane * (1.0 - 1e-12) > below > plane - _RIM * ball:
            area += radii[i] ** 2 * w
    lost = content - volume(radii, w)
    if lost <= 0.0:
        return
    half = 0.5 * lost if area > 0.0 else 0.0
    for i in range(len(u)):
        below = -radii[i] * u[i]
        if plane * (1.0 - 1e-12) > below > plane - _RIM * ball:
            radii[i] += half / area
    rescale(radii, w, volume(radii, w) + lost - half)


@kernel("void(float64[::1], float64[::1], float64, float64)")
def cut(radii: Any, u: Any, below: Any, above: Any) -> None:
    """Move the points under a plane at -below, or over one at `above`, onto it."""
    for i in range(len(u)):
        if -radii[i] * u[i] > below:
            radii[i] = below / -u[i]
        elif radii[i] * u[i] > above:
            radii[i] = above / u[i]


@kernel("void(float64[::1], float64, float64, float64)")
def turn(quaternion: Any, x: Any, y: Any, z: Any) -> None:
    """Turn a quaternion (w, x, y, z) by a rotation vector in world axes, rad."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle == 0.0:
        return
    a, s = math.cos(0.5 * angle), math.sin(0.5 * angle) / angle
    b, c, d = s * x, s * y, s * z
    w, i, j, k = quaternion
    quaternion[0] = a * w - b * i - c * j - d * k
    quaternion[1] = a * i + b * w + c * k - d * j
    quaternion[2] = a * j - b * k + c * w + d * i
    quaternion[3] = a * k + b * j - c * i + d * w
    quaternion /= math.sqrt(np.sum(quaternion * quaternion))


@kernel(
    "UniTuple(float64[::1], 2)(float64[::1], float64[::1], float64[:,::1], int64[:,::1], float64[:,:,::1],"
    " float64[:,::1], float64[:,::1], float64, float64[::1])"
)
def roll(
    radii: Any,
    quaternion: Any,
    vectors: Any,
    neighbours: Any,
    weights: Any,
    turns: Any,
    forces: Any,
    content: Any,
    dough: Any,
) -> Any:
    """Roll a lump of a volume, m^3, by rotation vectors (m, 3), rad, under forces (m, 2), N, of the hand and of the table.

    Changes radii (n,) and quaternion (4,) in place; returns its height (m,), m, under load, before each turn, and the part
    of the volume (m,) that was missing there once the displaced volume had been given back. A yield stress that is infinite
    leaves the shape alone.
    """
    w = 4.0 * math.pi / len(radii)
    u = np.empty(len(radii))
    heights, missing = np.empty(len(turns)), np.zeros(len(turns))
    ball = (0.75 * content / math.pi) ** (1.0 / 3.0)
    for step in range(len(turns)):
        upward(vectors, quaternion, u)
        low, high = extent(radii, u)
        heights[step] = low + high
        if math.isfinite(dough[YIELD]) and forces[step, 1] > 0.0:
            deep, plastic = sink(radii, u, w, content, low, low + high, forces[step, 1], dough)
            heights[step] -= deep
            line = waterline(radii, u, w, high, forces[step, 0], dough[FOUNDATION])
            cut(radii, u, low - plastic, math.inf)
            if dough[TENSION] > 0.0 and forces[step, 0] > 0.0:
                smooth(radii, u, neighbours, weights, line, ball, dough)
            give_back(radii, u, w, content, low - plastic, ball)
            missing[step] = centre(radii, vectors, neighbours, weights, w, content)
        turn(quaternion, turns[step, 0], turns[step, 1], turns[step, 2])
    return heights, missing


@kernel("void(float64[::1], float64[::1], float64[:,::1], int64[:,::1], float64[:,:,::1], float64, float64)")
def flatten(radii: Any, u: Any, vectors: Any, neighbours: Any, weights: Any, plastic: Any, content: Any) -> None:
    """Press a lump lower by a height, m, for good: its underside gets flat and its sides take the volume, in passes."""
    w = 4.0 * math.pi / len(radii)
    ball = (0.75 * content / math.pi) ** (1.0 / 3.0)
    passes = int(plastic / (_PASS * ball)) + 1
    low, high = extent(radii, u)
    aim = low + high - plastic
    for k in range(passes + 1):  # the last one mends the height, and leaves the centroid
        low, high = extent(radii, u)
        plane = max(low - (low + high - aim) / max(passes - k, 1), SMALLEST * ball)
        for _ in range(_SHARES):
            cut(radii, u, plane, high)
            lost, area = content - volume(radii, w), 0.0
            for i in range(len(u)):
                area += radii[i] ** 2 * w * (1.0 - u[i] * u[i]) ** 2
            for i in range(len(u)):
                radii[i] += lost / area * (1.0 - u[i] * u[i]) ** 2
        cut(radii, u, plane, high)
        if k == passes:
            break
        sunk = 0.0
        for i in range(len(u)):
            sunk += 0.25 * w / content * radii[i] ** 4 * u[i]
        level = np.empty(len(u))
        for i in range(len(u)):
            z = radii[i] * u[i]
            level[i] = -plane - sunk if z < 1e-9 * ball - plane else (high - sunk if z > high - 1e-9 * ball else 0.0)
        centre(radii, vectors, neighbours, weights, w, content)
        for i in range(len(u)):
            if level[i] * u[i] > 0.0:  # flat places stay flat
                radii[i] = level[i] / u[i]
    rescale(radii, w, content)
