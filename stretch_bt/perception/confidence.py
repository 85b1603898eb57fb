"""How probable it is that a label is right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.faces import Patch
from stretch_bt.perception.regions import border, distance
from stretch_bt.perception.smooth import enlarge, slope
from stretch_bt.perception.surface import Surface
from stretch_bt.perception.types import DEFORMED, INVALID, LabelArray

__all__ = ["confidence_of"]

Image = npt.NDArray[np.float32]

MODEL = 0.35  # kernel widths by which the edge of a contact is misplaced even without noise
UNDECIDED = 0.5


def confidence_of(surface: Surface, patches: Sequence[Patch], rise: Image, labels: LabelArray) -> Image:
    """Return the probability (h, w) that each label is right, 0 where it is invalid.

    The edge of a contact is misplaced by what the noise of its score comes to over the score's gradient, and by a share
    of the kernel; a label holds with the probability that the edge does not reach its pixel. In the same way a pixel is
    deformed or not with the probability that noise does not lift it past the threshold. Where the membrane is raised
    and no contact was found, one is there and was missed: every raised pixel counts as undecided.
    """
    raised = _normal(np.abs(rise) / np.float32(max(surface.smooth_sd, 1e-9)))
    if patches:
        signed = np.max([_signed(surface, patch) for patch in patches], axis=0)
        contact = _normal(np.abs(enlarge(signed, surface.step, labels.shape)))
        found = np.where(labels < DEFORMED, np.minimum(raised, contact), contact)
        found = np.where(labels == DEFORMED, np.minimum(raised, contact), found)
    else:
        found = np.where(labels == DEFORMED, np.float32(UNDECIDED), raised)
    found[labels == INVALID] = 0.0
    return np.asarray(found, dtype=np.float32)


def _signed(surface: Surface, patch: Patch) -> Image:
    """Return the distance of each bin from a patch's edge, positive inside, over the standard deviation of that edge."""
    inner, outer = border(patch.mask)
    ring = outer & ~inner
    steep = np.hypot(slope(patch.score, 1), slope(patch.score, 0))[ring]
    steep = steep[np.isfinite(steep)]
    gradient = float(np.median(steep)) if steep.size else 0.0
    random = patch.sd / max(gradient, 1e-12)
    sd = float(np.hypot(random, MODEL * surface.sigma))
    away = np.where(patch.mask, distance(patch.mask) - 0.5, 0.5 - distance(~patch.mask))
    return np.asarray(away / np.float32(sd), dtype=np.float32)


def _normal(z: Any) -> Image:
    """Return the standard normal distribution at z >= 0, to 1e-3 (logistic approximation of Bowling et al., 2009)."""
    return np.asarray(1.0 / (1.0 + np.exp(-z * (1.5976 + 0.07056 * z * z))), dtype=np.float32)
