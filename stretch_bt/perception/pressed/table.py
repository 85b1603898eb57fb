"""Shapes of the solved sheet under spheres, as the data that a benchmark command made, and splines through them.

Each shape is for a membrane of 100 by 90 mm with a sphere in its middle: the height of a quarter over the depth of the press,
without weight, at three thicknesses, as a thicker sheet bends less sharply, and the change by weight, over the sag of the free
membrane. The span is the distance of the clamps less the gauge: mount pre-stretch and stretch together.
`benchmarks/shape_table.py` makes the file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.quantity_text import format_apart
from stretch_bt.units import KINDS

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = ["Form", "Forms", "ShapeTable", "read_shapes"]

Array = npt.NDArray[np.float64]

ROUNDING = 1e-9


@dataclass(frozen=True)
class ShapeTable:
    """`lifted` (thicknesses, diameters, spans, depths, along, across), `hung` without the first; `free` (spans), m, is the hang of the free sheet.

    `across` and `along` are parts of half the width and half the length between the clamps; `deepest` (diameters, spans), m, is
    the deepest press that was solved.
    """

    lifted: Array
    hung: Array
    free: Array
    thicknesses: Array
    diameters: Array
    spans: Array
    depths: Array
    across: Array
    along: Array
    deepest: Array
    gauge: float
    width: float

    def hang(self, span: float, hang: float, known_at: float) -> float:
        """Return the hang, m, at a span, m, of a free membrane that hangs by `hang` at another span."""
        at = np.interp([span, known_at], self.spans, self.free)
        return float(hang * at[0] / at[1])

    def at(self, span: float, thickness: float) -> Forms:
        """Return the shapes at a span, m, of a membrane of a thickness, m; raises InvalidInput where these lie outside the table."""
        _require("span", span, self.spans)
        _require("thickness", thickness, self.thicknesses)
        weights, by_thickness = np.asarray(self._spline(span)), np.asarray(self._through(thickness))
        lifted = np.einsum("t,j,tijkyx->ikyx", by_thickness, weights, self.lifted, optimize=True)
        hung = np.einsum("j,ijkyx->ikyx", weights, self.hung)
        j = min(int(np.searchsorted(self.spans, span)), len(self.spans) - 1)
        deepest = self.deepest[:, max(j - 1, 0) : j + 1].min(axis=1)
        ends = self.across * self.width / 2, self.along * (self.gauge + span) / 2
        return Forms(lifted, hung, self.diameters, self.depths, deepest, *ends)

    @cached_property
    def _spline(self) -> CubicSpline:
        return _units(self.spans)

    @cached_property
    def _through(self) -> CubicSpline:
        return _units(self.thicknesses)


class Forms:
    """The shapes at one span; `lifted` and `hung` (diameters, depths, along, across) at places (across,) and (along,), m."""

    def __init__(
        self, lifted: Array, hung: Array, diameters: Array, depths: Array, deepest: Array, across: Array, along: Array
    ) -> None:
        self.lifted, self.hung, self.across, self.along = lifted, hung, across, along
        self.diameters, self.depths, self.deepest = diameters, depths, deepest
        self._splines = _units(np.log(diameters)), _units(np.log(depths))

    def form(self, radius: float, depth: float) -> Form:
        """Return the shape under a press; lengths in m.

        Raises
        ------
        InvalidInput
            The press lies outside the table.
        """
        _require("diameter", 2 * radius, self.diameters)
        i = min(int(np.searchsorted(self.diameters, 2 * radius)), len(self.diameters) - 1)
        _require("depth", depth, np.append(self.depths[0], self.deepest[max(i - 1, 0) : i + 1].min()))
        by_size, by_depth = (
            np.asarray(s(math.log(v))) for s, v in zip(self._splines, (2 * radius, depth), strict=True)
        )
        weights = np.outer(by_size, by_depth).reshape(-1)
        size = len(weights), len(self.along), len(self.across)
        lifted, hung = (np.tensordot(weights, values.reshape(size), 1) for values in (self.lifted, self.hung))
        return Form(lifted, hung, self.across, self.along)


def _require(name: str, value: float, known: Array) -> None:
    if not known[0] * (1 - ROUNDING) <= value <= known[-1] * (1 + ROUNDING):
        asked, least, most = format_apart(KINDS["Length"], value, float(known[0]), float(known[-1]))
        raise InvalidInput(f"shapes of the membrane are known for a {name} of {least} to {most}, not of {asked}")


def _units(places: Array) -> CubicSpline:
    """Return the spline of the unit vectors over some places: its values are the weights of the places."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(places, np.eye(len(places)))


class Form:
    """The shape under one press: `lifted` and `hung` (along, across) at places (across,) and (along,), m, of one quarter."""

    def __init__(self, lifted: Array, hung: Array, across: Array, along: Array) -> None:
        self._lifted, self._hung = (_mirrored(values, across, along) for values in (lifted, hung))

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height over the depth (n,), and what weight adds over the hang (n,), at places (n,), m."""
        return self._lifted.ev(y, x), self._hung.ev(y, x)

    def slopes(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the derivatives (n,), 1/m, of the height over the depth by x and by y."""
        return self._lifted.ev(y, x, dy=1), self._lifted.ev(y, x, dx=1)


def _mirrored(quarter: Array, across: Array, along: Array) -> Any:
    """Return a spline over the whole membrane from one quarter."""
    from scipy.interpolate import RectBivariateSpline

    half = np.concatenate([quarter[:, :0:-1], quarter], axis=1)
    whole = np.concatenate([half[:0:-1], half], axis=0)
    return RectBivariateSpline(np.concatenate([-along[:0:-1], along]), np.concatenate([-across[:0:-1], across]), whole)


@lru_cache(maxsize=1)
def read_shapes() -> ShapeTable:
    """Return the shipped table."""
    with files("stretch_bt.perception").joinpath("pressed/shapes.npz").open("rb") as stream, np.load(stream) as kept:
        arrays = {name: kept[name].astype(float) for name in kept.files}
    unit = float(arrays.pop("unit"))
    arrays.update({name: arrays[name] * unit for name in ("lifted", "hung")})
    found: dict[str, Any] = {name: values if values.ndim else float(values) for name, values in arrays.items()}
    return ShapeTable(**found)
