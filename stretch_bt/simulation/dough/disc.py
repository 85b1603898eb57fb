"""A lump pressed to a disc: how thin a force makes it, and the outline that it gets."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.dough.lump import Lump
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.solve import find_root

__all__ = ["cracked", "disc_force", "edge_roughness", "hull", "outline", "silhouette", "thickness"]

Array = npt.NDArray[np.float64]

_HARMONICS = 8  # of the outline: a field of 500 directions resolves none that is finer


def disc_force(volume: float, height: float, dough: Dough) -> float:
    """Return the force, N, that presses a disc of a volume, m^3, between plates to a height, m.

    Y pi a^2 (1 + 2 m a / (3 sqrt3 h)) for a friction factor m (Avitzur 1968, upper bound for a disc).
    """
    area = volume / height
    hill = 1 + 2 * dough.friction * math.sqrt(area / math.pi) / (3 * math.sqrt(3) * height)
    return dough.yield_stress * area * hill


def thickness(volume: float, force: float, dough: Dough) -> float:
    """Return the height, m, to which a force, N, presses a disc of a volume, m^3.

    Raises
    ------
    InvalidInput
        Volume or force is not above 0.
    """
    if not (volume > 0 and 0 < force < math.inf):
        raise InvalidInput(f"volume and force must be above 0, not {volume} m^3 and {force} N")
    low = dough.yield_stress * volume / force  # without friction
    high = 2 * low
    while disc_force(volume, high, dough) > force:
        high *= 2

    def over(log: float) -> tuple[float, float]:
        height = math.exp(log)
        value = disc_force(volume, height, dough)
        flat = dough.yield_stress * volume / height
        return math.log(value / force), -(flat + 2.5 * (value - flat)) / value

    return math.exp(find_root(over, math.log(low / 2), math.log(high), math.log(low), "a disc under a force").x)


def outline(lump: Lump, height: float, count: int = 180) -> Array:
    """Return the outline (count, 2), m, of a lump pressed to a height, m, without friction: each azimuth keeps its volume."""
    if not 0 < height < math.inf:
        raise InvalidInput(f"a disc has a finite height above 0 m, not {height}")
    points = _turned(lump)
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    shares = lump.radii**3 / 3 * lump.directions.solid_angle
    around = np.linspace(0, 2 * np.pi, count, endpoint=False)
    order = np.arange(1, _HARMONICS + 1)[:, None]
    along, across = (f(order * azimuth) @ shares for f in (np.cos, np.sin))
    volume = (shares.sum() / 2 + along @ np.cos(order * around) + across @ np.sin(order * around)) / np.pi
    radius = np.sqrt(2 * np.maximum(volume, 0.0) / height)
    return np.column_stack([radius * np.cos(around), radius * np.sin(around)])


def cracked(smooth: Array, roughness: float, correlation: float, seed: int = 0) -> Array:
    """Return an outline (n, 2), m, with cracks: its radius varies by a part `roughness` (sd), correlated over a length, m."""
    if not (roughness >= 0 and correlation > 0):
        raise InvalidInput(f"roughness is at least 0 and its length above 0 m, not {roughness} and {correlation}")
    count = len(smooth)
    length = float(np.linalg.norm(np.roll(smooth, -1, axis=0) - smooth, axis=1).sum())
    wave = 2 * np.pi * np.fft.rfftfreq(count, length / count)
    # the square root of the spectrum of exp(-(s / correlation)^2)
    shape = np.exp(-((wave * correlation) ** 2) / 8)
    shape[0] = 0.0
    noise = np.fft.irfft(np.fft.rfft(np.random.default_rng(seed).standard_normal(count)) * shape, count)
    gain = math.sqrt(count / (2 * np.sum(shape[1:] ** 2)))
    return smooth * (1 + roughness * gain * noise)[:, None]


def edge_roughness(line: Array) -> float:
    """Return the standard deviation of the radius of an outline (n, 2) about its first 8 harmonics, over its mean."""
    spectrum = np.fft.rfft(np.linalg.norm(line, axis=1))
    mean = float(spectrum[0].real)
    spectrum[: _HARMONICS + 1] = 0.0
    return float(np.fft.irfft(spectrum, len(line)).std() * len(line) / mean)


def hull(points: Array) -> Array:
    """Return the corners (n, 2) of the convex hull of points (m, 2), in order."""
    from scipy.spatial import ConvexHull

    return np.asarray(points[ConvexHull(points).vertices])


def silhouette(line: Array, height: float) -> Array:
    """Return the side view (n, 2), m, of a disc of an outline (m, 2), m: its side bulges in half a circle."""
    bulge = min(height / 2, float(np.ptp(line[:, 0])) / 2)
    angles = np.linspace(-np.pi / 2, np.pi / 2, 13)
    right = np.column_stack([line[:, 0].max() - bulge + bulge * np.cos(angles), height / 2 * (1 + np.sin(angles))])
    left = np.column_stack([line[:, 0].min() + bulge - bulge * np.cos(angles), height / 2 * (1 + np.sin(angles))])
    return np.vstack([right, left[::-1]])


def _turned(lump: Lump) -> Array:
    """Return the directions (n, 3) in world axes."""
    return np.asarray(lump.directions.vectors @ lump.rotation.T)
