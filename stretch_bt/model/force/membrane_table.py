"""Forces of the solved sheet under hemispheres, as the data that a benchmark command made, and splines through them.

A force is the force on a membrane of 100 by 90 mm divided by shear modulus, thickness and a hundredth of the gauge, which leaves it a
function of diameter, span and depth; the span is how far the clamps are apart past the gauge, mount pre-stretch and stretch together.
Weight adds to it, and bending, Mooney's second invariant, friction and softening by earlier presses change the sum by a part.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["MembraneTable", "SplineAxis", "read_table"]

Array = npt.NDArray[np.float64]
_LEAST = 0.05  # least part of a force that effects leave


class SplineAxis:
    """Cubic splines, not-a-knot, over fixed places; beyond the ends they go on as straight lines."""

    def __init__(self, places: Array) -> None:
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(places, np.eye(len(places)))
        self.places: list[float] = places.tolist()
        #: (4, pieces, places): from values at the places to the coefficients of each piece, cubic term first
        self.pieces: Array = spline.c
        ends = spline(places[[0, -1]], 1)
        self._before, self._past = ends[0], ends[1]

    def weights(self, at: float) -> Array:
        """Return (places,) float: the weight of each value at one place."""
        places = self.places
        if at <= places[0]:
            return self._line(0, self._before, at)
        if at >= places[-1]:
            return self._line(-1, self._past, at)
        k = bisect_right(places, at) - 1
        t, c = at - places[k], self.pieces
        found: Array = ((c[0, k] * t + c[1, k]) * t + c[2, k]) * t + c[3, k]
        return found

    def many(self, at: Array) -> Array:
        """Return (n, places) float: the weights at many places."""
        places, c = np.array(self.places), self.pieces
        k = np.clip(np.searchsorted(places, at, side="right") - 1, 0, len(places) - 2)
        t = (at - places[k])[:, None]
        found: Array = ((c[0, k] * t + c[1, k]) * t + c[2, k]) * t + c[3, k]
        for n in np.flatnonzero((at < places[0]) | (at > places[-1])):
            found[n] = self.weights(float(at[n]))
        return found

    def slopes(self) -> Array:
        """Return (places, places) float: from values at the places to the derivative there."""
        from scipy.interpolate import CubicSpline

        found: Array = CubicSpline(self.places, np.eye(len(self.places)))(self.places, 1)
        return found

    def _line(self, end: int, slope: Array, at: float) -> Array:
        found = slope * (at - self.places[end])
        found[end] += 1.0
        return found


@dataclass(frozen=True)
class MembraneTable:
    """Arrays are (diameters, spans, depths); `force` is the logarithm of the force, the others are the effects on it.

    `deepest` (diameters, spans), m, is how deep a press has an equilibrium. `softening` (diameters, pasts, depths) is of a
    membrane that has lost half of its stress; `pasts`, m, are how far the span is past the span at which it was softened.
    """

    diameters: Array
    spans: Array
    depths: Array
    deepest: Array
    force: Array
    sag: Array
    bending: Array
    mooney_low: Array
    mooney_high: Array
    friction: Array
    softening: Array
    pasts: Array
    shares: Array
    gauge: float
    width: float
    thickness: float
    density: float
    modulus: float
    coefficient: float

    @cached_property
    def axes(self) -> tuple[SplineAxis, SplineAxis, SplineAxis]:
        """Splines over the logarithm of the diameter, the span, and the logarithm of the depth."""
        return SplineAxis(np.log(self.diameters)), SplineAxis(self.spans), SplineAxis(np.log(self.depths))

    @cached_property
    def _mooney(self) -> tuple[Array, Array]:
        """The two coefficients of the parabola through no share and the two shares of the table."""
        low, high = self.mooney_low / self.shares[0], self.mooney_high / self.shares[1]
        bend = (high - low) / (self.shares[1] - self.shares[0])
        return low - bend * self.shares[0], bend

    def logarithms(
        self,
        spans: Array,
        *,
        share: float,
        friction: float,
        bending: float,
        weight: float,
        softening: float,
        softened: float,
    ) -> Array:
        """Return (diameters, n, depths) float: the logarithm of the force at spans (n,), m, with the effects.

        `share` is the share of the second invariant, the others are over the table's own; `softened` is the span, m, up to which the
        membrane was pressed before.
        """
        first, second = self._mooney
        part = 1 + share * (first + share * second) + friction * self.friction + bending * self.bending
        along = self.axes[1].many(spans)
        level, parts, sag = (_through(along, values) for values in (self.force, part, self.sag))
        if softening:
            pasts = np.clip(spans - softened, self.pasts[0], self.pasts[-1])
            parts = parts + softening * _through(self._past.many(pasts), self.softening)
        hanging = np.log(np.exp(level) + weight * np.maximum(sag, 0.0))
        found: Array = hanging + np.log(np.maximum(self._as_deep(level, hanging, parts), _LEAST))
        return found

    def _as_deep(self, level: Array, hanging: Array, parts: Array) -> Array:
        """Return parts as they are at the depths at which a membrane that does not hang has the force of one that does.

        A membrane that hangs is met earlier, and is pressed in further by then.
        """
        depths, out = np.log(self.depths), np.empty_like(parts)
        for i, j in np.ndindex(level.shape[:2]):
            out[i, j] = np.interp(np.interp(hanging[i, j], level[i, j], depths), depths, parts[i, j])
        return out

    @cached_property
    def _past(self) -> SplineAxis:
        return SplineAxis(self.pasts)

    def reach(self, diameter: float, span: float) -> float:
        """Return how deep a press has an equilibrium, m, the less of the places beside it."""
        i = min(max(bisect_right(self.diameters.tolist(), diameter) - 1, 0), len(self.diameters) - 2)
        j = min(max(bisect_right(self.spans.tolist(), span) - 1, 0), len(self.spans) - 2)
        return float(self.deepest[i : i + 2, j : j + 2].min())


def _through(along: Array, values: Array) -> Array:
    """Return values (diameters, spans, depths) at other spans, by weights (n, spans)."""
    found: Array = np.einsum("ny,iyk->ink", along, values)
    return found


@lru_cache(maxsize=1)
def read_table() -> MembraneTable:
    """Return the shipped table."""
    with files("stretch_bt.model").joinpath("data/membrane_force.npz").open("rb") as stream, np.load(stream) as kept:
        arrays = {name: kept[name].astype(float) for name in kept.files}
    found: dict[str, Any] = {name: values if values.ndim else float(values) for name, values in arrays.items()}
    return MembraneTable(**found)
