"""The cap under the hand, tabulated: force, flattening and the loss by a gas, by the drop of its top.

All in the cap's own units, so that one table serves every size and pressure: lengths over the radius R, forces over p R^2, and
the hand by kappa = k R / p, with its modulus k and the pressure p. `python -m benchmarks.balloons table` makes it.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.balloons.curve import PowerCurve, slopes

__all__ = ["PRESTRETCH", "CapTable", "TabulatedCap", "read_table"]

Array = npt.NDArray[np.float64]

#: prestretch of the table's skin
PRESTRETCH = 2.5


@dataclass(frozen=True, slots=True)
class TabulatedCap:
    """One cap in its own units: curves over the drop, and the drop at which the hand would reach the rim.

    `force` is over p R^2, `yields` is s of the gas, whose force is force / (1 + beta s) with beta from `Air.softness`, and
    `flattening` is the radius of the flattened top over R, less 1.
    """

    force: PowerCurve
    yields: PowerCurve
    flattening: PowerCurve
    limit: float


@dataclass(frozen=True)
class CapTable:
    """The table: `kappa` (n,) with the `limit` (n,) of each, `part` (m,) of the limit, and (n, m) the three functions of them."""

    kappa: Array
    part: Array
    force: Array
    yields: Array
    flattening: Array
    limit: Array

    def at(self, kappa: float) -> TabulatedCap:
        """Return a cap; past the ends of the table it is the cap at the end: a rigid plate, or a hand that is hardly there."""
        if not kappa > 0:
            raise InvalidInput(f"kappa must be above 0, not {kappa!r}")
        u = min(max(math.log(kappa), math.log(self.kappa[0])), math.log(self.kappa[-1]))
        knots = np.log(self.kappa)
        rows = [np.exp(_between(knots, np.log(rows), u)) for rows in (self.force, self.yields, self.flattening)]
        limit = math.exp(float(_between(knots, np.log(self.limit)[:, None], u)[0]))
        force, yields, flattening = (PowerCurve(limit * self.part, row, goes_on=row is rows[0]) for row in rows)
        return TabulatedCap(force, yields, flattening, limit)


def _between(x: Array, y: Array, at: float) -> Array:
    """Return the value (m,) of the cubics through points x (n,), y (n, m)."""
    k = int(np.clip(np.searchsorted(x, at, "right") - 1, 0, len(x) - 2))
    step = x[k + 1] - x[k]
    t = (at - x[k]) / step
    slope = np.stack([slopes(x, column) for column in y.T], axis=1)
    rise = (y[k + 1] - y[k]) / step
    c2, c3 = 3 * rise - 2 * slope[k] - slope[k + 1], slope[k] + slope[k + 1] - 2 * rise
    return np.asarray(y[k] + step * t * (slope[k] + t * (c2 + t * c3)))


@lru_cache(maxsize=1)
def read_table() -> CapTable:
    """Return the shipped table."""
    source = files("stretch_bt") / "simulation" / "balloons" / "data" / "cap.json"
    given = json.loads(source.read_text(encoding="utf-8"))
    return CapTable(**{name: np.array(given[name]) for name in CapTable.__dataclass_fields__})
