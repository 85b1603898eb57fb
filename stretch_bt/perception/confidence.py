"""How probable it is that a label is right."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.faces import Patch
from stretch_bt.perception.regions import Box, border, bounds, distance
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.smooth import slope
from stretch_bt.perception.surface import Surface
from stretch_bt.perception.tension import LEAST_PULL
from stretch_bt.units import Estimate

__all__ = ["confidence_of"]

Image = npt.NDArray[np.float32]

# A contact is labelled too wide even without noise: by SMEARED kernel widths over its radius in kernel widths, at most by SMEARED, as
# smoothed curvature reaches further than the contact; and by a mean and a deviation more, in kernel widths, over spheres,
# flat cylinders and cones, as part of the skirt of a slack sheet passes for contact.
SMEARED = 1.4
TAUT, UNKNOWN, SLACK = (0.0, 0.35), (0.4, 1.0), (2.0, 1.6)
LEAST_RATIO = 6.0  # ratio of the tensions from which a sheet of unknown stretch is pulled; it is 9 and more at 5 mm, and at most 4 at 0
UNDECIDED = 0.5
SURE = 4.0  # standard deviations from the edge beyond which nothing is worked out


def confidence_of(
    surface: Surface, patches: Sequence[Patch], rise: Image, ratio: Estimate | None, stretch: float | None
) -> Image:
    """Return the probability that the label of each bin is right, with the ratio of the tensions and the stretch, m, where they are known.

    The edge of a contact is misplaced by the noise of its score over the score's gradient, and by some
    kernel widths; a label holds with the probability that the edge does not reach its pixel. In the same way a pixel is
    deformed or not with the probability that noise does not lift it past the threshold, which `rise` is counted from.
    Where the membrane is raised and no contact was found, one is there and was missed: every raised pixel counts as
    undecided.
    """
    from stretch_bt.perception.classes_kernel import fill_confidence

    signed, sure = np.full(rise.shape, -SURE, dtype=np.float32), np.empty(rise.shape, dtype=np.float32)
    edge = _edge(ratio, stretch)
    held = np.zeros(rise.shape, dtype=bool)
    for patch in patches:
        window, near = _signed(patch, *edge)
        place = tuple(slice(a + s.start, a + s.stop) for a, s in zip(patch.surface.origin, window, strict=True))
        np.maximum(signed[place], near, out=signed[place])
        held[place] |= patch.mask[window]
    fill_confidence(signed, held, rise, max(surface.smooth_sd, 1e-9), sure)
    return sure if patches else np.where(rise > 0.0, np.float32(UNDECIDED), sure)


def _edge(ratio: Estimate | None, stretch: float | None) -> tuple[float, float]:
    """Return how far the edge of a contact lies within the labels, kernel widths, and the deviation of that between shapes."""
    if stretch is not None and stretch < LEAST_PULL:
        return SLACK
    pulled = ratio is not None and (stretch is not None or ratio.value >= LEAST_RATIO)
    return TAUT if pulled else UNKNOWN


def _signed(patch: Patch, out: float, model: float) -> tuple[Box, Image]:
    """Return a window of a patch, and there the distance of each bin from its edge, positive inside, over the standard deviation of that edge.

    The edge is expected within the mask by `out` kernel widths more than smoothing moves it, with a deviation of `model` of them.

    Beyond the window that is not above -SURE.
    """
    window = bounds(patch.mask, 2)
    mask, score = patch.mask[window], patch.score[window]
    inner, outer = border(mask)
    ring = outer & ~inner
    steep = np.hypot(slope(score, 1)[ring], slope(score, 0)[ring])
    gradient = quantile(steep) if steep.size else 0.0
    random = patch.sd / max(gradient, 1e-12)
    sd = float(np.hypot(random, model * patch.surface.sigma))
    radius = math.sqrt(np.count_nonzero(mask) / math.pi)
    within = patch.surface.sigma * (out + SMEARED * min(patch.surface.sigma / radius, 1.0))
    wide = bounds(patch.mask, int(min(SURE * sd, 1e4)) + 1)
    rows, columns = (slice(s.start, min(s.stop, n)) for s, n in zip(wide, patch.mask.shape, strict=True))
    mask = patch.mask[rows, columns]
    away = np.where(mask, distance(mask) - 0.5, 0.5 - distance(~mask))
    return (rows, columns), np.asarray((away - np.float32(within)) / np.float32(sd), dtype=np.float32)
