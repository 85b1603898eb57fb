"""How probable it is that a label is right."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.faces import Patch
from stretch_bt.perception.regions import Box, border, bounds, distance
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.smooth import slope
from stretch_bt.perception.surface import Surface

__all__ = ["confidence_of"]

Image = npt.NDArray[np.float32]

MODEL = 0.12  # kernel widths by which the edge of a contact is misplaced even without noise
UNKNOWN = 0.8  # the same where the tensions are not known, so that part of the skirt may pass for contact
UNDECIDED = 0.5
SURE = 4.0  # standard deviations from the edge beyond which nothing is worked out


def confidence_of(surface: Surface, patches: Sequence[Patch], rise: Image, *, known: bool) -> Image:
    """Return the probability that the label of each bin is right; `known` says whether the ratio of the tensions was.

    The edge of a contact is misplaced by what the noise of its score comes to over the score's gradient, and by a share
    of the kernel; a label holds with the probability that the edge does not reach its pixel. In the same way a pixel is
    deformed or not with the probability that noise does not lift it past the threshold, which `rise` is counted from.
    Where the membrane is raised and no contact was found, one is there and was missed: every raised pixel counts as
    undecided.
    """
    from stretch_bt.perception.classes_kernel import fill_confidence

    signed, sure = np.full(rise.shape, -SURE, dtype=np.float32), np.empty(rise.shape, dtype=np.float32)
    for patch in patches:
        window, near = _signed(patch, MODEL if known else UNKNOWN)
        place = tuple(slice(a + s.start, a + s.stop) for a, s in zip(patch.surface.origin, window, strict=True))
        np.maximum(signed[place], near, out=signed[place])
    fill_confidence(signed, rise, max(surface.smooth_sd, 1e-9), sure)
    return sure if patches else np.where(rise > 0.0, np.float32(UNDECIDED), sure)


def _signed(patch: Patch, model: float) -> tuple[Box, Image]:
    """Return a window of a patch, and there the distance of each bin from its edge, positive inside, over the standard deviation of that edge.

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
    wide = bounds(patch.mask, int(min(SURE * sd, 1e4)) + 1)
    rows, columns = (slice(s.start, min(s.stop, n)) for s, n in zip(wide, patch.mask.shape, strict=True))
    mask = patch.mask[rows, columns]
    away = np.where(mask, distance(mask) - 0.5, 0.5 - distance(~mask))
    return (rows, columns), np.asarray(away / np.float32(sd), dtype=np.float32)
