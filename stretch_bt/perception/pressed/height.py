"""Height of a sphere's top by the whole membrane: where the contact ends, the sheet's tension gives its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates, check_kind, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.perception.height import check_curvature
from stretch_bt.perception.pressed.table import Forms, read_shapes
from stretch_bt.perception.robust import MAD_TO_SD, TUKEY, quantile, tukey_weights
from stretch_bt.perception.surface import check_points
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["FORM_OFF", "MountedMembrane", "membrane_height", "mounted_membrane"]

Array = npt.NDArray[np.float64]

STRIDE = 4  # pixels; neighbours share their noise
SIDE, END = 0.85, 0.93  # shares of half the width and half the length within which the membrane is looked at
SIZES = 0.5, 2.0  # of the table's membrane, between which one stands for another
PROPORTION = 0.02  # largest relative difference of the width over the gauge from the table's
BLOCK = 0.010  # m, over which no noise is shared
OFFSET = 3e-5  # m; standard deviation of a camera's error that all heights share once its static error is subtracted
BESIDE = 5e-3  # m from the membrane's middle, within which a press counts as one in the middle
FORM_OFF = 2e-5  # m, error that all heights share, as friction and another rubber change the shape
STEEP, STEEPER = 0.35, 1.5e-4  # slope at the rim past which they change it more, and m for each unit of slope, at SPAN
SPAN = 0.02  # m
FLYING = 1e-3  # m
ROUNDS = 20
SETTLED = 1e-7  # m
LEAST_POINTS, LEAST_BLOCKS = 200, 20
LEAST_BEND = 0.3  # of the pull of residuals over their weight; noise of a camera has 0.83
LEAST = 2e-5  # m; residual of splines through the table
STEP = 0.02  # of depth and radius, over which the shape's derivatives are taken
UNSETTLED = "the shape of the membrane does not settle on the points seen; measure the height by the contact alone"
WRONG = 3e-4  # m, rms residual of blocks: no sphere in the middle of such a membrane


@dataclass(frozen=True, slots=True)
class MountedMembrane:
    """A membrane between its clamps; lengths in m, `thickness` before any stretch.

    `span` is the distance of the clamps less the gauge: mount pre-stretch and stretch together. `hang` is the sag of the free
    membrane in its middle at that span.
    """

    gauge: float
    width: float
    thickness: float
    span: float
    hang: Estimate

    def __post_init__(self) -> None:
        lengths = {name: getattr(self, name) for name in ("gauge", "width", "thickness", "span")}
        check_numbers("in m", **lengths)
        check_estimates(hang=self.hang)
        if not (self.gauge > 0 and self.width > 0 and self.thickness > 0):
            raise InvalidInput(
                f"gauge, width and thickness are above 0 m, not {self.gauge}, {self.width} and {self.thickness}"
            )
        _check_apart(self.gauge, self.span)


def _check_apart(gauge: float, span: float) -> None:
    """Raise InvalidInput unless clamps stand apart."""
    if not gauge + span > 0:
        raise InvalidInput(
            f"the clamps stand {gauge + span:g} m apart, which is above 0 m: the gauge and by how much prestretch and stretch pull it;"
            " give these in m"
        )


def mounted_membrane(
    gauge: float, width: float, thickness: float, prestretch: float, stretch: float, hang: Estimate
) -> MountedMembrane:
    """Return the membrane at a stretch, of one with such a mount pre-stretch that hangs by `hang` at stretch 0, m.

    Raises
    ------
    InvalidInput
        A length is no finite number, gauge, width or thickness is not above 0, or the clamps would stand closer than nothing.
    """
    check_numbers("in m", gauge=gauge, width=width, thickness=thickness, prestretch=prestretch, stretch=stretch)
    check_estimates(hang=hang)
    MountedMembrane(gauge, width, thickness, 0.0, hang)  # refuses what is none before it is scaled
    for span in (prestretch, prestretch + stretch):
        _check_apart(gauge, span)
    table = read_shapes()
    scale = gauge / table.gauge
    at = [(prestretch + x) / scale for x in (stretch, 0.0)]
    less = table.hang(at[0], 1.0, at[1])
    return MountedMembrane(gauge, width, thickness, prestretch + stretch, Estimate(less * hang.value, less * hang.sd))


def membrane_height(
    points: FloatArray, valid: MaskArray, membrane: MountedMembrane, curvature: Estimate, depth: float
) -> Estimate:
    """Return the height of a sphere's top in the middle of the membrane, z of the membrane frame, m, by all of the membrane.

    The shape of the solved sheet (`ShapeTable`) is fitted to all that is seen of it: depth, radius, place, the hang and a common offset,
    with Tukey's weights. Its standard deviation comes from residuals that blocks of 10 mm share, after Liang and Zeger (Biometrika 73, 13,
    1986), and from the effect of friction and other rubbers on a steep shape; their effect on all heights alike, FORM_OFF, is not in it.

    Parameters
    ----------
    points : (h, w, 3) float, m, membrane frame
    valid : (h, w) bool
    curvature
        Curvature of the sphere, 1/m, as it is known from elsewhere.
    depth
        A first guess of the height, m.

    Raises
    ------
    IllConditioned
        The points show no press of a sphere in the middle of such a membrane, or one beyond the table.
    InvalidInput
        Shapes that do not go together, or a curvature without a finite standard deviation above 0.
    """
    check_points(points, valid)
    check_kind("membrane", membrane, MountedMembrane, "`mounted_membrane` makes one")
    check_curvature(curvature)
    check_numbers("in m", depth=depth)
    if curvature.value <= 0:
        raise IllConditioned(
            "the top is not convex: it is no sphere's; press deeper, or measure the height without a sphere"
        )
    table = read_shapes()
    scale = membrane.gauge / table.gauge
    if not SIZES[0] <= scale <= SIZES[1]:
        raise IllConditioned(
            f"the shapes known are of a membrane {table.gauge * 1e3:g} mm long, not {membrane.gauge * 1e3:g} mm;"
            " measure the height by the contact alone"
        )
    if abs(membrane.width / membrane.gauge / (table.width / table.gauge) - 1) > PROPORTION:
        raise IllConditioned(
            f"the shapes known are of membranes with sides as {table.width:g} to {table.gauge:g}; measure the height by the contact alone"
        )
    seen = _seen(points, valid, membrane) / scale
    try:
        return _Fit(_forms(membrane.span / scale, membrane.thickness / scale), seen, membrane, scale, curvature).solve(
            depth / scale
        )
    except InvalidInput as error:
        raise IllConditioned(str(error)) from error
    except OverflowError as error:
        raise IllConditioned(UNSETTLED) from error


@lru_cache(maxsize=4)
def _forms(span: float, thickness: float) -> Forms:
    return read_shapes().at(span, thickness)


def _seen(points: FloatArray, valid: MaskArray, membrane: MountedMembrane) -> Array:
    """Return some of the points (3, n), m, that lie well within the membrane's sides and clamps."""
    some, good = points[::STRIDE, ::STRIDE].reshape(-1, 3), valid[::STRIDE, ::STRIDE].reshape(-1)
    narrower = SIDE / math.sqrt(1 + membrane.span / membrane.gauge)
    across = min(narrower, float(read_shapes().across[-1])) * membrane.width / 2
    along = END * (membrane.gauge + membrane.span) / 2
    near = good & (np.abs(some[:, 0]) < across) & (np.abs(some[:, 1]) < along) & np.isfinite(some[:, 2])
    if np.count_nonzero(near) < LEAST_POINTS:
        raise IllConditioned(
            "too little of the membrane is seen to fit its shape; keep the whole of it in view, free of reflections"
        )
    return np.ascontiguousarray(some[near].T, dtype=np.float64)


class _Fit:
    """Gauss-Newton over (depth, ln radius, offset, x, y, hang); lengths are scaled to the table's membrane."""

    def __init__(self, forms: Forms, seen: Array, membrane: MountedMembrane, scale: float, curvature: Estimate) -> None:
        self.forms, self.scale, self.span = forms, scale, membrane.span / scale
        self.x, self.y, self.z = seen
        hang = Estimate(membrane.hang.value / scale, membrane.hang.sd / scale)
        self.prior = np.array([0.0, -math.log(curvature.value * scale), 0.0, 0.0, 0.0, hang.value])
        lengths = OFFSET / scale, BESIDE / scale, BESIDE / scale, max(hang.sd, 1e-6)
        self.prior_sd = np.array([np.inf, curvature.sd / curvature.value, *lengths])
        if self._blocks < LEAST_BLOCKS:
            raise IllConditioned(
                "too little of the membrane is seen to fit its shape; keep the whole of it in view, free of reflections"
            )

    def solve(self, depth: float) -> Estimate:
        """Return the depth with its standard deviation."""
        q = self.prior.copy()
        q[0] = depth
        for _ in range(ROUNDS):
            left, design = self._residuals(q)
            sd = max(MAD_TO_SD * quantile(np.abs(left)), LEAST)
            weight = tukey_weights(left / (TUKEY * sd))
            normal, pull = self._normal(design, left, weight, q, sd)
            step = np.linalg.solve(normal, pull)
            q = q + step
            if abs(step[0]) < SETTLED:
                break
        else:
            raise IllConditioned(UNSETTLED)
        if self._misfit(left) * self.scale > WRONG or math.hypot(q[3], q[4]) * self.scale > BESIDE:
            raise IllConditioned(
                "the points show no press of a sphere in the middle of the membrane; move the hand over the object's"
                " top, or measure the height by the contact alone"
            )
        own = self._sd(design, left, weight, normal, sd) * self.scale
        return Estimate(float(q[0]) * self.scale, math.hypot(own, self._form_off(q) * self.scale))

    def _form_off(self, q: Array) -> float:
        """Return the error of the height when the table's shapes stand for other hands', as `benchmarks/shape_table.py` checks it."""
        slope = math.sqrt(max(float(q[0]), 0.0) / (2 * math.exp(q[1])))
        return STEEPER * max(slope - STEEP, 0.0) * self.span / SPAN

    def _residuals(self, q: Array) -> tuple[Array, Array]:
        """Return the residuals of the heights (n,), and the design (n, 6)."""
        depth, radius, hang = float(q[0]), math.exp(q[1]), float(q[5])
        x, y = self.x - q[3], self.y - q[4]
        form = self.forms.form(radius, depth)
        lifted, hung = form.heights(x, y)
        deeper = self._other(radius, depth * (1 + STEP), x, y, hang)
        larger = self._other(radius * (1 + STEP), depth, x, y, hang)
        here = depth * lifted + hang * hung
        slopes = form.slopes(x, y)
        columns = [(deeper - here) / (STEP * depth), (larger - here) / math.log1p(STEP), np.ones_like(here)]
        columns += [-depth * slopes[0], -depth * slopes[1], hung]
        return self.z - here - q[2], np.stack(columns, axis=1)

    def _other(self, radius: float, depth: float, x: Array, y: Array, hang: float) -> Array:
        lifted, hung = self.forms.form(radius, depth).heights(x, y)
        return np.asarray(depth * lifted + hang * hung)

    def _normal(self, design: Array, left: Array, weight: Array, q: Array, sd: float) -> tuple[Array, Array]:
        """Return the normal matrix and right side; priors count against as many values as there are independent blocks."""
        own = self._own(sd)
        weighed = design * weight[:, None]
        return weighed.T @ design + np.diag(own), weighed.T @ left + own * (self.prior - q) * np.isfinite(self.prior_sd)

    def _own(self, sd: float) -> Array:
        """Return the part of the normal matrix's diagonal (6,) that the priors add."""
        return np.asarray((sd * math.sqrt(len(self.z) / self._blocks) / self.prior_sd) ** 2)

    def _misfit(self, left: Array) -> float:
        """Return the rms, m, of the mean residuals of blocks, each of which counts by its points, pixels that fly held back."""
        count = np.bincount(self._block)
        means = np.bincount(self._block, np.clip(left, -FLYING / self.scale, FLYING / self.scale)) / count
        return math.sqrt(float(np.average(means**2, weights=count)))

    @cached_property
    def _block(self) -> npt.NDArray[np.int64]:
        """The number of each point's block."""
        size = BLOCK / self.scale
        places = np.floor(self.x / size) * 1000 + np.floor(self.y / size)
        return np.asarray(np.unique(places, return_inverse=True)[1], dtype=np.int64)

    @property
    def _blocks(self) -> int:
        return int(self._block.max()) + 1

    def _sd(self, design: Array, left: Array, weight: Array, normal: Array, sd: float) -> float:
        """Return the standard deviation of the depth from residuals that are alike within a block."""
        scores = np.zeros((self._blocks, design.shape[1]))
        np.add.at(scores, self._block, design * (weight * left)[:, None])
        own = self._own(sd)
        # A residual's pull grows by less than its weight where the biweight bends over: Huber's mean slope of it.
        inside = (left / (TUKEY * sd)) ** 2
        bends = np.mean(np.sqrt(weight) * (1 - 5 * inside)) / np.mean(weight)
        inverse = np.linalg.inv(max(float(bends), LEAST_BEND) * (normal - np.diag(own)) + np.diag(own))
        priors = own**2 * np.where(np.isfinite(self.prior_sd), self.prior_sd, 0.0) ** 2
        spread = inverse @ (scores.T @ scores + np.diag(priors)) @ inverse
        return math.sqrt(float(spread[0, 0]))
