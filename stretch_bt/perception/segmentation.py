"""The three classes of the membrane: undeformed, deformed, in contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, partial
from itertools import islice
from typing import Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.brief import BriefRepr
from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.perception.confidence import confidence_of
from stretch_bt.perception.correlation import area_of
from stretch_bt.perception.faces import Effort, Patch, flat_or_round, highest, holds_summit, with_above_plane
from stretch_bt.perception.held import check_held
from stretch_bt.perception.lateral import lateral
from stretch_bt.perception.noise_of_frame import noise_spectrum
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.regions import Box, border, bounds, parts, placed
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.scale import SEED, Ground, Scale, Signal, either_scale, ground_of, mean_scale
from stretch_bt.perception.smooth import enlarge, grown
from stretch_bt.perception.surface import Cleaned, binned_surface, check_points, clean
from stretch_bt.perception.tension import expected_ratio
from stretch_bt.perception.types import INVALID, UNDEFORMED, FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["Rule", "Segmentation", "classify", "segment"]

Rule = Literal["mean", "either"]
Image = npt.NDArray[np.float32]

KERNELS = (1.9e-3, 2.7e-3, 3.8e-3)  # m; the finest in which the contact stands out is used
COARSE = 3.8e-3  # m; shows how much there is to see, at a quarter of the cost
HIGHEST = 2.7e-3  # m; for the rule that goes by height
MOST_PARTS = 10  # places that stand out, each at 6 standard deviations; a press of one object shows one or two
CLEAR = 7.0  # standard deviations at which a kernel is wide enough
# A contact that rises by less than LIGHT, m, must be curved by more than HIDDEN of SEED standard deviations of noise of any length, which a narrow
# kernel takes for membrane. Free membranes reach 0.67 (one of 288 frames 0.70). Light presses reach 0.75 or more under noise alike over up to 3
# pixels, less under longer noise (`free`, `cap` and `analytic light` of `python -m benchmarks.height_noise`).
LIGHT, HIDDEN = 2e-3, 0.7


@dataclass(frozen=True, slots=True, repr=False)
class Segmentation(BriefRepr):
    """The classes of a frame and the numbers that they rest on.

    `labels` (h, w) uint8 and `confidence` (h, w) float32, the probability that a label is right, 0 where invalid;
    `noise` of one pixel and `plane`, the height of the undeformed membrane, m; `ratio` of the tensions along j and i,
    None where the frame does not show it and for the rule "either", which asks for none; `noise_area` is how many pixels
    share one error.
    """

    labels: LabelArray
    confidence: Image
    noise: float
    plane: float
    ratio: Estimate | None = None
    noise_area: float = 1.0


def segment(points: FloatArray, valid: MaskArray, *, rule: Rule = "mean", stretch: float | None = None) -> LabelArray:
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
        Stretch of the membrane; narrows the ratio down where the frame is noisy.

    Returns
    -------
    labels : (h, w) uint8
        0 undeformed, 1 deformed but not in contact, 2 in contact, 255 invalid. All thresholds come from the noise that
        the frame itself shows.

    Raises
    ------
    IllConditioned
        Noise of the camera is taken for more places in contact than an object makes, or points in the membrane frame show no membrane:
        their ends stand out of its plane, or some lie far behind or before it or are parted from it by an edge.
    """
    return classify(points, valid, rule=rule, stretch=stretch).labels


def classify(
    points: FloatArray, valid: MaskArray, *, rule: Rule = "mean", stretch: float | None = None, towards: int = 0
) -> Segmentation:
    """Do as `segment`, and return confidence, noise, plane and ratio of the tensions with the labels.

    `towards` is +1 for points in the membrane frame, -1 in the camera frame, 0 to distinguish them as `segment` does.
    """
    if not isinstance(rule, str) or rule not in ("mean", "either"):
        raise InvalidInput(f"rule is 'mean' or 'either', got {shown(rule)[:80]}")
    if not isinstance(towards, int) or towards not in (-1, 0, 1):
        raise InvalidInput(f"towards is 1, -1 or 0, got {shown(towards)[:80]}")
    check_points(points, valid)
    cleaned = clean(points, valid, towards)
    if cleaned is None:
        labels = np.where(valid, UNDEFORMED, INVALID).astype(np.uint8)
        return Segmentation(labels, np.where(valid, np.float32(0.5), np.float32(0)), 0.0, 0.0)
    return _result(cleaned, *_best_scale(cleaned, rule, expected_ratio(stretch)), stretch)


def _best_scale(cleaned: Cleaned, rule: Rule, expected: Estimate) -> tuple[Scale, list[Patch]]:
    """Return the finest kernel at which a contact is clear, or the clearest, with the contacts it shows."""
    fine = binned_surface(cleaned, KERNELS[0])
    noise, moves = (fine.noise, fine.length), lateral(cleaned, KERNELS[0])

    def ground(kernel: float) -> Ground:
        return ground_of(kernel, fine if kernel == KERNELS[0] else binned_surface(cleaned, kernel, noise))

    def at(kernel: float, ratio: Estimate | None) -> Scale:
        place = ground(kernel)
        return mean_scale(place, moves, expected, ratio) if rule == "mean" else either_scale(place, moves)

    coarse, crowded, effort = at(COARSE, None), None, Effort()
    if cleaned.towards > 0:
        check_held(cleaned, coarse.ground.whole)
    best: tuple[Scale, list[Patch]] | None = None
    for kernel in _kernels(coarse.clearness):
        scale = coarse if kernel == COARSE else at(kernel, coarse.ratio)
        try:
            patches, crowded = _patches(scale, effort), None
        except IllConditioned as error:
            patches, crowded = [], error
            if kernel != COARSE and _is_crowded(coarse, effort):
                best = None
                break  # a frame that is crowded there is so at every finer kernel
        if _holds_top(scale.ground, patches) and (best is None or best[0].clearness <= scale.clearness):
            best = scale, patches
        if best and best[0].clearness >= CLEAR:
            break
    spectrum = cache(partial(noise_spectrum, cleaned, free=np.ones(cleaned.valid.shape, dtype=bool)))
    if best is not None and _is_light(best[0].ground) and _hides(spectrum(), best[0], HIDDEN):
        best = None
    if best is not None:
        return best
    if crowded is not None and not _hides(spectrum(), coarse):
        raise crowded
    place = ground(HIGHEST)
    found = highest(place.surface, place.plane, lambda: spectrum().after(place.surface)) if rule == "mean" else []
    return Scale(place, (), coarse.ratio), found


def _is_crowded(scale: Scale, effort: Effort) -> bool:
    try:
        _patches(scale, effort)
    except IllConditioned:
        return True
    return False


def _is_light(ground: Ground) -> bool:
    """Whether the membrane rises by less than LIGHT."""
    return float(_rise(ground).max()) < LIGHT


def _hides(noise: NoiseSpectrum, scale: Scale, share: float = 1.0) -> bool:
    """Whether all that looks curved is below a `share` of SEED standard deviations of noise of any length."""
    surface = scale.ground.surface
    noise_sd = noise.after(surface, (2, 0, 1.0)) / surface.pitch**2
    return all(scale.clearness * signal.sd < share * SEED * noise_sd for signal in scale.signals)


def _kernels(clearness: float) -> list[float]:
    """Return the kernels to try: from the finest at which what stands out should be clear, up.

    The noise of a second derivative falls with the third power of the kernel, and its peak at a rim with the first. What
    is not clear at the coarse kernel may be too small for it, so that all are tried.
    """
    if clearness < CLEAR:
        return list(KERNELS)
    enough = COARSE * (CLEAR / max(clearness, 0.01)) ** 0.5
    return [k for k in KERNELS if k >= 0.95 * enough]


def _holds_top(ground: Ground, patches: list[Patch]) -> bool:
    """Whether the highest part of the membrane is in contact; a membrane in tension has no summit elsewhere."""
    if not patches:
        return False
    rise = _rise(ground)
    peak = float(rise.max())
    top = rise > peak - max(3.0 * ground.surface.smooth_sd, 0.02 * peak)
    return bool(2 * np.count_nonzero(_held(ground, patches) & top) >= np.count_nonzero(top))


def _rise(ground: Ground) -> Image:
    """Return how far each trusted bin of the raised part rises, m, 0 elsewhere."""
    return np.asarray((ground.surface.smooth - np.float32(ground.plane)) * (ground.raised & ground.surface.trusted))


def _held(ground: Ground, patches: list[Patch]) -> MaskArray:
    """Return which bins of the raised part are in contact."""
    held = np.zeros(ground.raised.shape, dtype=bool)
    for patch in patches:
        _hold(held, ground, patch)
    return held


def _hold(held: MaskArray, ground: Ground, patch: Patch) -> None:
    """Add a contact to the bins of the raised part that are in contact."""
    v, u = (a - b for a, b in zip(patch.surface.origin, ground.surface.origin, strict=True))
    held[v : v + patch.mask.shape[0], u : u + patch.mask.shape[1]] |= patch.mask


def _result(cleaned: Cleaned, scale: Scale, patches: list[Patch], stretch: float | None) -> Segmentation:
    """Return the labels of the whole image."""
    from stretch_bt.perception.classes_kernel import fill_classes

    ground, step = scale.ground, scale.ground.whole.step
    rise = ground.whole.smooth - np.float32(ground.plane + ground.least_rise)
    sure = confidence_of(ground.whole, patches, rise, scale.ratio, stretch)
    touching = np.zeros(cleaned.valid.shape, dtype=bool)
    for patch in patches:
        _draw(touching, patch)
    labels = np.full(cleaned.shape, INVALID, dtype=np.uint8)
    confidence = np.zeros(cleaned.shape, dtype=np.float32)
    fill_classes(grown(rise, step), grown(sure, step), touching, cleaned.valid, *cleaned.corner, labels, confidence)
    plane = ground.plane + ground.whole.level
    area = area_of(ground.whole.length)
    noise = math.hypot(ground.whole.noise, cleaned.stripes.sd)
    return Segmentation(labels, confidence, noise, plane, scale.ratio, area)


def _draw(touching: MaskArray, patch: Patch) -> None:
    """Mark the pixels of a patch of bins: along its border the score decides, which is finer than the bins."""
    from stretch_bt.perception.regions_kernel import draw

    step, window = patch.surface.step, bounds(patch.mask, 2)
    inner, outer = border(patch.mask[window])
    score = enlarge(patch.score[window], step, (inner.shape[0] * step, inner.shape[1] * step))
    v, u = ((first + s.start) * step for first, s in zip(patch.surface.origin, window, strict=True))
    draw(inner, outer, score, step, touching[v : v + len(score), u : u + score.shape[1]])


def _convex(signal: Signal, raised: MaskArray) -> list[tuple[Box, MaskArray, float]]:
    """Return each connected part with more than half its own typical curvature: a box, the part there, the threshold, 1/m.

    Raises IllConditioned where there are more than an object makes.
    """
    found = []
    strong = raised & (signal.curvature > SEED * signal.sd)
    blobs = list(islice(parts(raised & (signal.curvature > signal.least), strong), MOST_PARTS + 1))
    if len(blobs) > MOST_PARTS:
        raise IllConditioned(
            f"more than {MOST_PARTS} separate places look curved, and an object makes a few: most are errors of the camera, or it sees no"
            " membrane; keep reflections and direct light off the membrane, and look where the camera points"
        )
    for box, blob in blobs:
        curvature = signal.curvature[box]
        values = curvature[blob]
        level = quantile(values, 0.9)
        for _ in range(4):
            level = quantile(values[values > 0.5 * level])
        threshold = max(signal.least, 0.5 * level)
        kept = blob & (curvature > threshold)
        inner = bounds(kept, 0)
        whole = bounds(kept, 0, corner=(box[0].start, box[1].start))
        found.append((whole, kept[inner], threshold))
    return found


def _patches(scale: Scale, effort: Effort) -> list[Patch]:
    """Return the contacts that the signals of a scale show."""
    found = _round_and_flat(scale, effort) if len(scale.signals) == 1 else _above_either(scale, effort)
    return [patch for patch in found if patch.mask.any() and holds_summit(patch)]


def _round_and_flat(scale: Scale, effort: Effort) -> list[Patch]:
    ground, signal, found = scale.ground, scale.signals[0], list[Patch]()
    held = np.zeros(ground.raised.shape, dtype=bool)
    for box, part, threshold in _convex(signal, ground.raised):
        # Two sides of one rim need one face only.
        if 3 * np.count_nonzero(part & held[box]) < np.count_nonzero(part):
            patch = flat_or_round(ground.surface, box, part, signal, threshold, ground.raised, effort)
            _hold(held, ground, patch)
            found.append(patch)
    return found


def _above_either(scale: Scale, effort: Effort) -> list[Patch]:
    either = np.zeros(scale.ground.raised.shape, dtype=bool)
    score = np.full(scale.ground.raised.shape, -1.0, dtype=np.float32)
    sd = 1.0
    for signal in scale.signals:
        found = _convex(signal, scale.ground.raised)
        for box, part, threshold in found:
            either[box] |= part
            sd = signal.sd / threshold
        thresholds = [threshold for _, _, threshold in found]
        # The highest over all of them: by the least where convex, by the greatest where concave.
        for threshold in {min(thresholds, default=0.0), max(thresholds, default=0.0)} - {0.0}:
            np.maximum(score, signal.curvature / np.float32(threshold) - 1.0, out=score)
    whole = (placed(part, box, np.s_[:, :], scale.ground.raised.shape) for box, part in parts(either, either))
    score /= np.float32(max(sd, 1e-9))
    return [with_above_plane(scale.ground.surface, part, score, effort) for part in whole]
