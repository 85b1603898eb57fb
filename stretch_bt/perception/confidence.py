"""How probable it is that a label is right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.faces import Patch
from stretch_bt.perception.regions import border, bounds, distance
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.smooth import enlarge, slope
from stretch_bt.perception.surface import Surface

__all__ = ["confidence_of"]

Image = npt.NDArray[np.float32]

MODEL = 0.12  # kernel widths by which the edge of a contact is misplaced even without noise
UNKNOWN = 0.8  # the same where the tensions are not known, so that part of the skirt may pass for contact
UNDECIDED = 0.5
SURE = 4.0  # standard deviations from the edge beyond which nothing is worked out


def confidence_of(
    surface: Surface,
    origin: tuple[int, int],
    patches: Sequence[Patch],
    rise: Image,
    shape: tuple[int, int],
    *,
    known: bool,
) -> Image:
    """Return the probability that the label of each pixel is right, (h, w) of `shape`; patches begin at bin `origin`, and `known` says
    whether the ratio of the tensions was.

    The edge of a contact is misplaced by what the noise of its score comes to over the score's gradient, and by a share
    of the kernel; a label holds with the probability that the edge does not reach its pixel. In the same way a pixel is
    deformed or not with the probability that noise does not lift it past the threshold, which `rise` is counted from.
    Where the membrane is raised and no contact was found, one is there and was missed: every raised pixel counts as
    undecided.
    """
    raised = np.abs(rise) / np.float32(max(surface.smooth_sd, 1e-9))
    if not patches:
        return enlarge(np.where(rise > 0.0, np.float32(UNDECIDED), _normal(raised)), surface.step, shape)
    signed = np.full(rise.shape, -SURE, dtype=np.float32)
    for patch in patches:
        place = tuple(slice(a, a + n) for a, n in zip(origin, patch.mask.shape, strict=True))
        np.maximum(signed[place], _signed(surface, patch, MODEL if known else UNKNOWN), out=signed[place])
    return enlarge(_normal(np.where(signed > 0.0, signed, np.minimum(raised, -signed))), surface.step, shape)


def _signed(surface: Surface, patch: Patch, model: float) -> Image:
    """Return the distance of each bin from a patch's edge, positive inside, over the standard deviation of that edge."""
    window = bounds(patch.mask, 2)
    mask, score = patch.mask[window], patch.score[window]
    inner, outer = border(mask)
    ring = outer & ~inner
    steep = np.hypot(slope(score, 1)[ring], slope(score, 0)[ring])
    gradient = quantile(steep) if steep.size else 0.0
    random = patch.sd / max(gradient, 1e-12)
    sd = float(np.hypot(random, model * surface.sigma))
    window = bounds(patch.mask, int(min(SURE * sd, 1e4)) + 1)
    mask = patch.mask[window]
    away = np.full(patch.mask.shape, -SURE, dtype=np.float32)
    away[window] = np.where(mask, distance(mask) - 0.5, 0.5 - distance(~mask)) / np.float32(sd)
    return away


def _normal(z: Any) -> Image:
    """Return the standard normal distribution at z >= 0, to 1e-3 (logistic approximation of Bowling et al., 2009)."""
    return np.asarray(1.0 / (1.0 + np.exp(-z * (1.5976 + 0.07056 * z * z))), dtype=np.float32)
