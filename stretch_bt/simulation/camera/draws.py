"""Random numbers for images, drawn faster than one by one."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

__all__ = ["normal", "places"]

Image = npt.NDArray[np.float32]
_QUANTILES = 65536


def normal(random: np.random.Generator, shape: tuple[int, ...]) -> Image:
    """Return standard normal numbers, each one of 65536 evenly likely ones; none is beyond 4.4."""
    count = int(np.prod(shape))
    return _table().take(np.frombuffer(random.bytes(2 * count), np.uint16)).reshape(shape)


@lru_cache(maxsize=1)
def _table() -> Image:
    from scipy.special import ndtri

    middle = ndtri((np.arange(_QUANTILES) + 0.5) / _QUANTILES)
    return np.asarray(middle / middle.std(), np.float32)


def places(random: np.random.Generator, count: int, share: float) -> npt.NDArray[np.int64]:
    """Return which of `count` pixels are drawn, rising, when each is with the probability `share`, by the gaps between them."""
    found = np.empty(0, np.int64)
    if share <= 0 or count == 0:
        return found
    last = -1
    while last < count:
        few = int((count - last) * share * 1.1) + 16
        # a gap past the end is as good as one to it, and their sum stays a number
        more = last + np.cumsum(np.minimum(random.geometric(share, few), count + 1))
        found, last = np.concatenate([found, more]), int(more[-1])
    return found[: np.searchsorted(found, count)]
