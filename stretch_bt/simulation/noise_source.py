"""Seeds of everything random in a simulation."""

from __future__ import annotations

import zlib

import numpy as np

__all__ = ["noise_source"]

_ALWAYS = 1 << 32  # stands for the number of noise that is the same in all samples of a run


def noise_source(seed: int, source: str, number: int) -> np.random.Generator:
    """Return the noise source of one sample of the source of this name; the same for the same seed, whatever was asked before.

    A negative number stands for noise that is the same in all samples of a run.
    """
    return np.random.default_rng((seed, zlib.crc32(source.encode()), number if number >= 0 else _ALWAYS - number))
