"""Statistics of a camera's noise, measured the same way on real frames and on simulated ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.noise import pixel_noise

__all__ = ["Deviations", "Texture", "deviations_of", "texture_of"]

_LAGS = 3
_QUIET = 0.1  # share of the patches of about one depth, those with least residual: on the others the scene has a texture itself
_DEPTHS = (0.45, 0.60, 0.70, 0.80, 1.00)  # m; between two of them patches are of about one depth
_FEW = 30


@dataclass(frozen=True, slots=True)
class Deviations:
    """Deviations of the frames of a still scene from the truth.

    `sd`, m, is the one over all pixels of all frames, `beside` (3,) the correlation of pixels 1 to 3 apart, along rows and
    columns, `after` the one of a pixel with itself a frame later, `fixed`, m, the standard deviation of the pixels' means over
    the frames, and `lost` the share without a value.
    """

    sd: float
    beside: npt.NDArray[np.float64]
    after: float
    fixed: float
    lost: float


@dataclass(frozen=True, slots=True)
class Texture:
    """Noise of single frames on smooth surfaces: residuals from quadratics over patches of 15 pixels.

    `growth`, 1/m, is their standard deviation over the square of depth, on the quietest tenth of the patches, and `beside`
    (3,) the correlation of pixels 1 to 3 apart.
    """

    growth: float
    beside: npt.NDArray[np.float64]


def deviations_of(frames: Sequence[npt.NDArray[np.float32]], truth: npt.NDArray[np.float32]) -> Deviations:
    """Measure frames (h, w) float32, m, 0 where invalid, of a scene whose depth (h, w) float32, m, is known.

    Raises
    ------
    InvalidInput
        There are fewer than two frames.
    """
    if len(frames) < 2:
        raise InvalidInput(f"deviations take at least two frames, got {len(frames)}")
    stack = np.stack(frames).astype(np.float64)
    seen = stack > 0
    off = np.where(seen, stack - truth, 0.0)
    sd = float(np.sqrt((off**2).sum() / max(seen.sum(), 1)))
    aside = [
        0.5 * (_together(off[:, :, k:], off[:, :, :-k], seen[:, :, k:], seen[:, :, :-k]))
        + 0.5 * (_together(off[:, k:], off[:, :-k], seen[:, k:], seen[:, :-k]))
        for k in range(1, _LAGS + 1)
    ]
    after = _together(off[1:], off[:-1], seen[1:], seen[:-1])
    means = off.sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    return Deviations(sd, np.array(aside), after, float(means.std()), float(1 - seen.mean()))


def _together(
    one: npt.NDArray[np.float64],
    other: npt.NDArray[np.float64],
    seen: npt.NDArray[np.bool_],
    also: npt.NDArray[np.bool_],
) -> float:
    """Return the correlation about 0 over the pairs that are seen, 0 where nothing varies."""
    both = seen & also
    power = np.sqrt((one[both] ** 2).sum() * (other[both] ** 2).sum())
    return float((one[both] * other[both]).sum() / power) if power > 0 else 0.0


def texture_of(frames: Iterable[DepthFrame]) -> Texture:
    """Measure frames of smooth things between 0.45 and 1 m away.

    Raises
    ------
    IllConditioned
        Too few smooth patches are seen.
    """
    found = [pixel_noise(frame, lags=_LAGS) for frame in frames]
    sd, depth = (np.concatenate([getattr(one, name) for one in found]) for name in ("sd", "depth"))
    growths = []
    for low, high in pairwise(_DEPTHS):
        there = (depth >= low) & (depth < high)
        if there.sum() >= _FEW:
            growths.append(np.quantile(sd[there], _QUIET) / np.median(depth[there]) ** 2)
    if not growths:
        raise IllConditioned(f"a texture takes {_FEW} smooth patches of about one depth, 0.45 to 1 m away")
    return Texture(float(np.median(growths)), np.mean([one.correlation for one in found], axis=0))
