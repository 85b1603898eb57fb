"""The three classes of the membrane: undeformed, deformed, in contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.perception.confidence import confidence_of
from stretch_bt.perception.curvature import Bending, bending, spread
from stretch_bt.perception.faces import Patch, flat_or_round, with_above_plane
from stretch_bt.perception.regions import border, enlarge_mask, parts, widened
from stretch_bt.perception.robust import sample
from stretch_bt.perception.smooth import enlarge, gain
from stretch_bt.perception.surface import Cleaned, Surface, binned_surface, clean
from stretch_bt.perception.tension import combine, expected_ratio, tension_ratio
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, UNDEFORMED, FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["Rule", "Segmentation", "classify", "segment"]

Rule = Literal["mean", "either"]
Image = npt.NDArray[np.float32]

KERNELS = (1.9e-3, 2.7e-3, 3.8e-3, 5.4e-3)  # m; the first one in which the contact stands out is used
CLEAR = 9.0  # standard deviations at which a kernel is wide enough
SEED = 6.0  # standard deviations that a contact must show somewhere
GROW = 3.0  # and everywhere


@dataclass(frozen=True, slots=True)
class Segmentation:
    """The classes of a frame and what they rest on.

    `labels` (h, w) uint8 and `confidence` (h, w) float32, the probability that a label is right, 0 where invalid;
    `noise` of one pixel and `plane`, the height of the undeformed membrane, m; `ratio` of the tensions along j and i,
    None for the rule "either", which asks for none.
    """

    labels: LabelArray
    confidence: Image
    noise: float
    plane: float
    ratio: Estimate | None = None


def segment(
    points: FloatArray, valid: MaskArray, *, rule: Rule = "mean", stretch: float | None = None
) -> LabelArray:
    """Sort the pixels of one frame into three classes.

    Parameters
    ----------
    points : (h, w, 3) float, m
        In the camera frame (z forward) or the membrane frame (z towards the camera, undeformed membrane at 0). Where
        the median z exceeds 0.4 of the width seen, they are taken to be in the camera frame.
    valid : (h, w) bool
    rule : "mean" or "either"
        "mean": the mean curvature, weighted by the tensions along the axes, is high; on the skirt of a membrane in
        tension it is 0 however steep that is. The ratio of the tensions comes from the frame itself. "either": the
        paper's rule, the curvature along i or along j is high, which takes in part of the skirt. Points above the
        plane of the contact belong to it as well, in the first rule if its face is flat, in the second always.
    stretch : float, m, optional
        Of the membrane; narrows the ratio down where the frame is noisy.

    Returns
    -------
    labels : (h, w) uint8
        0 undeformed, 1 deformed but not in contact, 2 in contact, 255 invalid. All thresholds come from the noise that
        the frame itself shows.
    """
    return classify(points, valid, rule=rule, stretch=stretch).labels


def classify(
    points: FloatArray, valid: MaskArray, *, rule: Rule = "mean", stretch: float | None = None
) -> Segmentation:
    """Do as `segment`, and return confidence, noise, plane and ratio of the tensions with the labels."""
    if rule not in ("mean", "either"):
        raise InvalidInput(f"rule is 'mean' or 'either', got {rule!r}")
    cleaned = clean(points, valid)
    if cleaned is None:
        labels = np.where(valid, UNDEFORMED, INVALID).astype(np.uint8)
        return Segmentation(labels, np.where(valid, np.float32(0.5), np.float32(0)), 0.0, 0.0)
    expected = expected_ratio(stretch)
    first: _Scale | None = None
    for kernel in KERNELS:
        scale = _mean_scale(cleaned, kernel, expected) if rule == "mean" else _either_scale(cleaned, kernel)
        first = first or scale
        if scale.is_clear:
            return _result(cleaned, scale, rule)
    assert first is not None
    return _result(cleaned, first, rule)


@dataclass(frozen=True, slots=True)
class _Signal:
    """A curvature, 1/m, in bins, its noise, and the least that counts."""

    curvature: Image
    sd: float
    least: float


@dataclass(frozen=True, slots=True)
class _Scale:
    """A frame at one kernel: its surface, the height of the undeformed membrane, what is raised, and its signals."""

    surface: Surface
    plane: float
    least_rise: float
    raised: MaskArray
    signals: tuple[_Signal, ...]
    ratio: Estimate | None

    @property
    def is_clear(self) -> bool:
        """Whether a signal stands out well enough to draw its edge."""
        return any(float(np.max(s.curvature, where=self.raised, initial=0.0)) > CLEAR * s.sd for s in self.signals)


def _raised(cleaned: Cleaned, kernel: float) -> tuple[Surface, float, float, MaskArray]:
    surface = binned_surface(cleaned, kernel)
    plane = _plane(surface)
    least = _least_rise(surface)
    return surface, plane, least, surface.smooth - np.float32(plane) > least


def _mean_scale(cleaned: Cleaned, kernel: float, expected: Estimate) -> _Scale:
    """Return a frame at one kernel with its weighted mean curvature, and the ratio of the tensions that weights it."""
    surface, plane, least, raised = _raised(cleaned, kernel)
    bent = bending(surface)
    ratio = expected
    for _ in range(2):
        signal = _weighted(surface, bent, ratio.value)
        if not raised.any():
            break
        strong = raised & (signal.curvature > SEED * signal.sd)
        off = raised & surface.trusted & ~widened(strong, 2.0 * surface.sigma)
        try:
            found = tension_ratio(bent.xx[off], bent.yy[off], apart=np.pi * surface.sigma**2)
        except IllConditioned:
            break
        ratio = combine(expected, found)
    return _Scale(surface, plane, least, raised, (_weighted(surface, bent, ratio.value),), ratio)


def _weighted(surface: Surface, bent: Bending, ratio: float) -> _Signal:
    """Return the mean curvature weighted by the tensions.

    (h_xx + k h_yy) / ((1 + h_x^2 + k (1 + h_y^2)) sqrt(1 + h_x^2 + h_y^2)), its sign turned, is 1/R on any sphere, and 0
    where only tensions act.
    """
    k = np.float32(ratio)
    metric = (1.0 + k) + bent.x * bent.x + k * (bent.y * bent.y)
    curvature = -(bent.xx + k * bent.yy) / (metric * bent.root)
    curvature[~surface.trusted] = 0.0
    white = bent.white * gain(surface.sigma, (2, 0, 1.0), (0, 2, round(ratio, 2))) / (1.0 + ratio)
    sd = spread(curvature, surface.trusted, white)
    return _Signal(curvature, sd, max(GROW * sd, 1.0 / _width(surface)))


def _either_scale(cleaned: Cleaned, kernel: float) -> _Scale:
    surface, plane, least, raised = _raised(cleaned, kernel)
    bent = bending(surface)
    flattest = 1.0 / _width(surface)
    signals = tuple(_Signal(k, sd, max(GROW * sd, flattest)) for k, sd in ((bent.i, bent.i_sd), (bent.j, bent.j_sd)))
    return _Scale(surface, plane, least, raised, signals, None)


def _width(surface: Surface) -> float:
    """Return the width of the view, m: a radius beyond it is a plane that is not quite flat."""
    return float(max(surface.height.shape) * surface.pitch)


def _plane(surface: Surface) -> float:
    """Return the height of the undeformed membrane above the surface's level, m."""
    if surface.towards > 0:
        return -surface.level
    seen = sample(surface.smooth, surface.trusted & surface.valid)
    # In the camera frame the membrane's distance is unknown; its lowest part is taken to be undeformed.
    return float(np.quantile(seen, 0.05)) + 1.645 * surface.smooth_sd if seen.size else 0.0


def _least_rise(surface: Surface) -> float:
    """Return the rise, m, from which a bin counts as deformed; half a pixel's noise covers what is not white."""
    return max(3.0 * surface.smooth_sd, 0.5 * surface.noise, 0.01 * surface.sigma * surface.pitch)


def _result(cleaned: Cleaned, scale: _Scale, rule: Rule) -> Segmentation:
    """Return the labels of the whole image."""
    surface, shape = scale.surface, cleaned.valid.shape
    patches = _round_and_flat(scale) if rule == "mean" else _above_either(scale)
    rise = enlarge(surface.smooth, surface.step, shape) - np.float32(scale.plane + scale.least_rise)
    near = np.where(rise > 0.0, np.uint8(DEFORMED), np.uint8(UNDEFORMED))
    for patch in patches:
        near[_in_pixels(patch, surface.step, shape)] = CONTACT
    near[~cleaned.valid] = INVALID
    labels = np.full(cleaned.shape, INVALID, dtype=np.uint8)
    labels[cleaned.box] = near
    confidence = np.zeros(cleaned.shape, dtype=np.float32)
    confidence[cleaned.box] = confidence_of(surface, patches, rise, near)
    return Segmentation(labels, confidence, surface.noise, scale.plane + surface.level, scale.ratio)


def _in_pixels(patch: Patch, step: int, shape: tuple[int, int]) -> MaskArray:
    """Return a patch of bins in pixels: along its border the score decides, which is finer than the bins."""
    inner, outer = border(patch.mask)
    score = enlarge(patch.score, step, shape)
    return np.asarray(enlarge_mask(inner, step, shape) | (enlarge_mask(outer, step, shape) & (score > 0.0)))


def _convex(signal: _Signal, raised: MaskArray) -> list[tuple[MaskArray, float]]:
    """Return each connected part with more than half its own typical curvature, and that threshold, 1/m."""
    found = []
    strong = raised & (signal.curvature > SEED * signal.sd)
    for blob in parts(raised & (signal.curvature > signal.least), strong):
        values = signal.curvature[blob]
        level = float(np.quantile(values, 0.9))
        for _ in range(4):
            level = float(np.median(values[values > 0.5 * level]))
        threshold = max(signal.least, 0.5 * level)
        found.append((blob & (signal.curvature > threshold), threshold))
    return found


def _round_and_flat(scale: _Scale) -> list[Patch]:
    signal = scale.signals[0]
    return [
        flat_or_round(scale.surface, part, signal.curvature - np.float32(threshold), threshold, signal.sd, scale.raised)
        for part, threshold in _convex(signal, scale.raised)
    ]


def _above_either(scale: _Scale) -> list[Patch]:
    either = np.zeros(scale.raised.shape, dtype=bool)
    score = np.full(scale.raised.shape, -np.inf, dtype=np.float32)
    sd = 1.0
    for signal in scale.signals:
        for part, threshold in _convex(signal, scale.raised):
            either |= part
            np.maximum(score, signal.curvature / np.float32(threshold) - 1.0, out=score)
            sd = signal.sd / threshold
    return [with_above_plane(scale.surface, part, score, sd) for part in parts(either, either)]
