"""The noise of one frame, and over how many pixels it is alike, from what no smooth surface explains."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import FloatArray

__all__ = ["SurfaceNoise", "surface_noise"]

Array = npt.NDArray[np.float64]

TILE = 48  # pixels: many times as long as noise is alike, and short against the membrane
ORDER = 3  # of the polynomial that a tile is freed of
REACH = 14  # pixels at which noise is no longer alike, so that what is left there is the surface's
SEEN = 0.9  # share of a tile that must be valid
CLEAR = 4.0  # standard deviations from which neighbours count as correlated
FADED = 0.01  # correlation that counts as none


@dataclass(frozen=True, slots=True)
class SurfaceNoise:
    """Standard deviation, m, of one pixel's height, and the number of pixels that share one error, at least 1."""

    sd: float
    area: float


def surface_noise(surface: FloatArray) -> SurfaceNoise | None:
    """Return the noise of a surface (h, w, 3), m, NaN where invalid; None where no whole tile of it is seen.

    Each tile is freed of a polynomial, and what this takes of alike noise is added again. The correlation along rows and columns over the quieter half of the tiles, less what
    is left of it at REACH, is summed over the plane as if it were the same in all directions.
    """
    heights = _tiles(np.asarray(surface[..., 2], dtype=np.float64))
    if heights is None:
        return None
    rest = _freed(heights)
    power = (rest**2).mean(axis=(1, 2))
    quiet = rest[power <= np.median(power)]
    products = np.array([_alike(quiet, lag) for lag in range(REACH + 1)])
    if products[0] == 0.0:
        return SurfaceNoise(0.0, 1.0)
    clear = products[1] * np.sqrt(2.0 * quiet.size) > CLEAR * products[0]
    noise = products - products[-1] if clear else products
    area = _summed(noise / noise[0]) if clear and noise[0] > 0.0 else 1.0
    left = 1.0 - min(area * _polynomials().shape[1] / TILE**2, 0.5)
    return SurfaceNoise(float(np.sqrt(max(noise[0], 0.0) / left)), max(area / left, 1.0) if clear else 1.0)


def _tiles(height: Array) -> Array | None:
    """Return the tiles (m, TILE, TILE) of an image that are seen almost whole, their holes still NaN."""
    rows, columns = (n // TILE for n in height.shape)
    if not rows or not columns:
        return None
    cut = height[: rows * TILE, : columns * TILE].reshape(rows, TILE, columns, TILE)
    tiles = cut.transpose(0, 2, 1, 3).reshape(-1, TILE, TILE)
    whole = tiles[np.isfinite(tiles).mean(axis=(1, 2)) >= SEEN]
    return whole if len(whole) else None


@lru_cache(maxsize=1)
def _polynomials() -> Array:
    """Return an orthonormal basis (TILE^2, p) of the polynomials over a tile."""
    u = np.linspace(-1.0, 1.0, TILE)
    x, y = (w.ravel() for w in np.meshgrid(u, u))
    powers = [x**i * y**j for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]
    return np.asarray(np.linalg.qr(np.column_stack(powers))[0])


def _freed(tiles: Array) -> Array:
    """Return tiles less their polynomial, 0 where they have holes."""
    flat = tiles.reshape(len(tiles), -1)
    seen = np.isfinite(flat)
    middle = (np.where(seen, flat, 0.0).sum(axis=1) / seen.sum(axis=1))[:, None]
    basis = _polynomials()
    explained = np.broadcast_to(middle, flat.shape)
    for _ in range(3):  # holes take the polynomial of the round before
        explained = np.where(seen, flat, explained) @ basis @ basis.T
    return np.where(seen, flat - explained, 0.0).reshape(tiles.shape)


def _alike(tiles: Array, lag: int) -> float:
    """Return the mean product of values a lag apart along rows and columns."""
    end = TILE - lag
    along = (tiles[:, lag:] * tiles[:, :end]).mean()
    across = (tiles[:, :, lag:] * tiles[:, :, :end]).mean()
    return float(along + across) / 2.0


def _summed(correlation: Array) -> float:
    """Return the sum over the plane of a correlation at whole distances, up to where it has faded."""
    faded = np.flatnonzero(correlation < FADED)
    end = int(faded[0]) if faded.size else correlation.size
    distance = np.arange(1, end)
    return 1.0 + float(2.0 * np.pi * (distance * correlation[1:end]).sum())
