"""Masks of bins: what hangs together with a part, and how a patch looks in pixels, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["draw", "flood"]


@kernel("void(boolean[:,:],boolean[:,:],uint8[:,::1])")
def flood(mask: Any, part: Any, hit: Any) -> None:
    """Mark what of a mask hangs together, also across corners, with what of a part lies in it; `hit` comes as 0."""
    h, w = mask.shape
    waiting, count = np.empty(h * w, dtype=np.int64), 0
    for v in range(h):
        for u in range(w):
            if part[v, u] and mask[v, u]:
                hit[v, u] = 1
                waiting[count] = v * w + u
                count += 1
    while count:
        count -= 1
        v, u = waiting[count] // w, waiting[count] % w
        for i in range(max(v - 1, 0), min(v + 2, h)):
            for j in range(max(u - 1, 0), min(u + 2, w)):
                if mask[i, j] and not hit[i, j]:
                    hit[i, j] = 1
                    waiting[count] = i * w + j
                    count += 1


@kernel("void(boolean[:,:],boolean[:,:],float32[:,:],int64,boolean[:,:])")
def draw(inner: Any, outer: Any, score: Any, step: Any, place: Any) -> None:
    """Mark the pixels (h, w) of bins of `step` pixels: all of an inner bin, those of an outer one whose score is above 0."""
    for v in range(place.shape[0]):
        sure, near, scores, row = inner[v // step], outer[v // step], score[v], place[v]
        for bin_ in range(sure.size):
            if near[bin_]:
                for u in range(bin_ * step, min((bin_ + 1) * step, row.size)):
                    row[u] = row[u] or sure[bin_] or scores[u] > 0.0
