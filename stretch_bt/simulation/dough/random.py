"""Normal numbers that depend on a seed and a place in a row alone, whatever was asked before."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["normals"]


def normals(seed: int, first: int, count: int) -> npt.NDArray[np.float64]:
    """Return (count,) standard normal numbers at places `first` and on; hashes of splitmix64 (Steele et al. 2014)."""
    place = np.arange(first, first + count, dtype=np.uint64) * np.uint64(2)
    start = _mix(np.array([seed & (2**64 - 1)], dtype=np.uint64))
    one, other = (_uniform(_mix((place + np.uint64(k)) ^ start)) for k in (0, 1))
    return np.asarray(np.sqrt(-2 * np.log(one)) * np.cos(2 * np.pi * other))  # Box & Muller 1958


def _mix(z: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    z = z * np.uint64(0x9E3779B97F4A7C15) + np.uint64(0x632BE59BD9B4E019)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def _uniform(z: npt.NDArray[np.uint64]) -> npt.NDArray[np.float64]:
    return ((z >> np.uint64(11)).astype(float) + 0.5) / 2.0**53
