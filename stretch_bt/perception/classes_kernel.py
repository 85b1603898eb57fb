"""Labels and their confidence, bin by bin and pixel by pixel, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.types import CONTACT, INVALID

__all__ = ["fill_classes", "fill_confidence"]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
C1, C2, C3, C4 = np.float32(0.196854), np.float32(0.115194), np.float32(0.000344), np.float32(0.019527)


@kernel("void(float32[:,::1],boolean[:,::1],float32[:,::1],float32,float32[:,::1])")
def fill_confidence(signed: Any, held: Any, rise: Any, sd: Any, sure: Any) -> None:
    """Fill the probability that a bin's label is right; see `confidence.confidence_of`.

    `signed` is how far a bin is within a contact, in standard deviations, `held` whether it is labelled so, `rise` its height above
    the threshold, m. The normal distribution is that of Abramowitz and Stegun, Handbook of Mathematical Functions, 26.2.18, to 2.5e-4.
    """
    for v in range(rise.shape[0]):
        inside, touches, raised, found = signed[v], held[v], rise[v], sure[v]
        for u in range(rise.shape[1]):
            side = inside[u] if touches[u] else min(abs(raised[u]) / sd, -inside[u])
            z = abs(side)
            p = ONE + z * (C1 + z * (C2 + z * (C3 + z * C4)))
            wrong = HALF / ((p * p) * (p * p))
            found[u] = wrong if side < ZERO else ONE - wrong


@kernel("void(float32[:,::1],float32[:,::1],boolean[:,::1],boolean[:,::1],int64,int64,uint8[:,::1],float32[:,::1])")
def fill_classes(
    rise: Any, sure: Any, touching: Any, valid: Any, v0: Any, u0: Any, labels: Any, confidence: Any
) -> None:
    """Fill labels and confidence of the whole image from row v0 and column u0 on, of `touching` and valid pixels (h, w)."""
    for v in range(valid.shape[0]):
        high, share, held, seen = rise[v], sure[v], touching[v], valid[v]
        label, found = labels[v0 + v, u0:], confidence[v0 + v, u0:]
        for u in range(valid.shape[1]):
            deformed = np.uint8(high[u] > ZERO)  # DEFORMED is 1, UNDEFORMED 0
            kind = np.uint8(CONTACT) if held[u] else deformed
            label[u] = kind if seen[u] else np.uint8(INVALID)
            found[u] = share[u] if seen[u] else ZERO
