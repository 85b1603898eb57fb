"""How a lump on a plate resists a press, compiled; `dough` (8,) holds Dough.numbers."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["answer", "flow", "share"]

YIELD, MODULUS, FOUNDATION, TENSION, RELAXATION, HILL, CONSISTENCY, POWER = range(8)
PATCH, SECTION = 2.8, 1.2
_HALVINGS = 60


@kernel("UniTuple(float64, 2)(float64, float64, float64, float64, float64[::1])")
def flow(star: Any, content: Any, tall: Any, deep: Any, dough: Any) -> Any:
    """Return the area of a contact, m^2, and the force, N, at which a lump flows once it is pressed `deep`, m.

    Its section there was `star`, m^2; it spreads as the lump gets flat: all of a cube's section, all of the volume
    `content`, m^3, over the rest of the height `tall`. The mean pressure is 2.8 Y on a small patch (Tabor 1951) down
    to 1.2 Y on all of a ball's section, and at least the pressure of a disc between plates with friction, 1 + 2 m a / (3 sqrt3 h)
    (Avitzur 1968); area times pressure rises with the area.
    """
    left = tall - min(deep, 0.999 * tall)
    spread = min(star * tall / content, 1.0) * (tall - left) / left
    area = min(star * (1.0 + spread), content / left)
    radius = math.sqrt(area / math.pi)
    part = min(radius / (0.75 * content / math.pi) ** (1.0 / 3.0), 1.0)
    hill = 1.0 + 2.0 * dough[HILL] * radius / (3.0 * math.sqrt(3.0) * left)
    return area, max(PATCH - (PATCH - SECTION) * part**1.5, hill) * dough[YIELD] * area


@kernel("float64(float64, float64, float64, float64, float64, float64, float64[::1])")
def carried(area: Any, flows: Any, tall: Any, deep: Any, before: Any, dt: Any, dough: Any) -> Any:
    """Return the force, N, at the end of a step of dt, s, to a depth, m, by implicit return mapping.

    Elastic part F / (2 E* a) and plastic part share the depth, the latter `before`, m, at the begin; the yield stress rises
    by K (plastic rate)^n (Herschel & Bulkley 1926). The residual is monotone in F, so halving finds it.
    """
    thickening = dough[CONSISTENCY] / dough[YIELD]
    stiffness = 2.0 * dough[MODULUS] * math.sqrt(area / math.pi)
    elastic = stiffness * deep
    if elastic <= flows or thickening <= 0.0:
        return min(elastic, flows)
    if math.isinf(stiffness):
        return flows * (1.0 + thickening * (max(deep - before, 0.0) / (tall * dt)) ** dough[POWER])
    least, most = flows, elastic
    for _ in range(_HALVINGS):
        force = 0.5 * (least + most)
        rate = max(deep - force / stiffness - before, 0.0) / (tall * dt)
        if flows * (1.0 + thickening * rate ** dough[POWER]) > force:
            least = force
        else:
            most = force
    return 0.5 * (least + most)


@kernel("float64(float64[:,::1], float64)")
def share(table: Any, deep: Any) -> Any:
    """Return the section at a depth, m, by the monotone cubics of a table (k, 3): depths, sections and their slopes."""
    last = table.shape[0] - 1
    if deep >= table[last, 0]:
        return table[last, 1]
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= deep:
            low = middle
        else:
            high = middle
    width = table[high, 0] - table[low, 0]
    t = (deep - table[low, 0]) / width
    rise = table[high, 1] - table[low, 1]
    before, after = width * table[low, 2], width * table[high, 2]
    return table[low, 1] + t * (before + t * (3.0 * rise - 2.0 * before - after + t * (before + after - 2.0 * rise)))


@kernel("UniTuple(float64, 2)(float64[:,::1], float64, float64, float64, float64, float64, float64[::1])")
def answer(table: Any, content: Any, tall: Any, deep: Any, before: Any, dt: Any, dough: Any) -> Any:
    """Return force, N, and plastic depth, m, of a press `deep`, m, in a step of dt, s."""
    if deep <= 0.0:
        return 0.0, 0.0
    area, flows = flow(share(table, deep), content, tall, deep, dough)
    if area <= 0.0:
        return 0.0, 0.0
    force = carried(area, flows, tall, deep, before, dt, dough)
    stiffness = 2.0 * dough[MODULUS] * math.sqrt(area / math.pi)
    return force, max(deep - force / stiffness, 0.0)
