"""How a patch of bins looks in pixels, compiled."""

from __future__ import annotations

from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["draw"]


@kernel("void(boolean[:,:],boolean[:,:],float32[:,:],int64,boolean[:,:])")
def draw(inner: Any, outer: Any, score: Any, step: Any, place: Any) -> None:
    """Mark the pixels (h, w) of bins of `step` pixels: all of an inner bin, those of an outer one whose score is above 0."""
    for v in range(place.shape[0]):
        sure, near, scores, row = inner[v // step], outer[v // step], score[v], place[v]
        for bin_ in range(sure.size):
            if near[bin_]:
                for u in range(bin_ * step, min((bin_ + 1) * step, row.size)):
                    row[u] = row[u] or sure[bin_] or scores[u] > 0.0
