"""Closed outlines and masks whose area and circularity are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["PITCH", "jittered", "mask", "outline", "true_area", "true_circularity"]

Array = npt.NDArray[np.float64]
PITCH = 0.4e-3  # m
OVAL = 0.9  # short over long axis


def _corners(shape: str, size: float) -> Any:
    turn = np.exp(2j * np.pi * np.arange(4000) / 4000)
    return {
        "disc": size / 2 * turn,
        "oval": size / 2 * (turn.real + 1j * OVAL * turn.imag),
        "square": size * np.array([0, 1, 1 + 1j, 1j]),
        "triangle": size * np.exp(2j * np.pi * np.arange(3) / 3),
    }[shape]


def true_circularity(shape: str) -> float:
    """Return 4 pi area / perimeter^2 of a shape."""
    fine = _corners(shape, 1.0)
    area = 0.5 * float((fine.conj() * np.roll(fine, -1)).imag.sum())
    return float(4 * np.pi * area / np.abs(np.roll(fine, -1) - fine).sum() ** 2)


def true_area(shape: str, size: float = 25e-3) -> float:
    """Return the area, m^2, of a shape of `size`, m."""
    return size**2 * {"disc": np.pi / 4, "oval": np.pi / 4 * OVAL, "square": 1.0}[shape]


def outline(shape: str, size: float = 25e-3, pitch: float = PITCH, start: float = 0.3) -> Array:
    """Return vertices (n, 2) every `pitch` along a shape; its corners need not be among them."""
    corners = _corners(shape, size)
    closed = np.append(corners, corners[0])
    along = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(closed)))])
    count = round(along[-1] / pitch)
    at = (np.arange(count) + start) * along[-1] / count % along[-1]
    return np.column_stack([np.interp(at, along, closed.real), np.interp(at, along, closed.imag)])


def jittered(vertices: Array, sd: float, seed: int) -> Array:
    """Move each vertex along the normal by independent noise of `sd`."""
    along = np.roll(vertices, -1, axis=0) - np.roll(vertices, 1, axis=0)
    normal = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return np.asarray(vertices + normal * np.random.default_rng(seed).normal(0.0, sd, len(vertices))[:, None])


def mask(
    shape: str, size: float = 25e-3, pitch: float = PITCH, seed: int = 0, flips: float = 0.0
) -> npt.NDArray[np.bool_]:
    """Draw a shape at a random place and angle; each pixel at its border changes sides with probability `flips`."""
    rng = np.random.default_rng(seed)
    count = int(size / pitch * 1.8)
    middle, angle = count / 2 + rng.uniform(-0.5, 0.5, 2), rng.uniform(0, np.pi)
    v, u = np.mgrid[:count, :count]
    z = ((u - middle[0]) + 1j * (v - middle[1])) * pitch * np.exp(1j * angle) / size
    inside = {
        "disc": np.abs(z) < 0.5,
        "oval": np.hypot(z.real, z.imag / OVAL) < 0.5,
        "square": np.maximum(np.abs(z.real), np.abs(z.imag)) < 0.5,
    }[shape]
    border = np.zeros_like(inside)
    for axis in (0, 1):
        for step in (-1, 1):
            border |= inside != np.roll(inside, step, axis)
    return np.asarray(inside ^ (border & (rng.random(inside.shape) < flips)))
