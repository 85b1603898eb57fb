"""How far the top of a lump, as the membrane shows it, is from a sphere."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.perception.types import Contact
from stretch_bt.units import Estimate

__all__ = ["cap_residual"]

Array = npt.NDArray[np.float64]

CELL = 2e-3  # m; pixels are averaged over cells of this size, finer than any facet that counts
RIM = 0.8  # share of the contact's radius that the membrane's bend at the rim leaves alone
LEAST = 16  # cells
LEAST_PIXELS = 4  # of a cell
PARAMETERS = 4


def cap_residual(contact: Contact) -> Estimate:
    """Return the root mean square distance of a contact from the sphere that fits it best, m, without that of the noise.

    Points are averaged over cells of 2 mm. The variance that the frame's own noise leaves in such a mean is taken off; where it
    is more than what is there, the residual is 0, and its standard deviation says how much that hides.

    Raises
    ------
    IllConditioned
        The contact is too small: fewer than 16 cells.
    """
    cells, noise = _cells(contact)
    if len(cells) < LEAST:
        raise IllConditioned(f"the contact covers {len(cells)} cells of 2 mm; a residual needs {LEAST}")
    away = _from_sphere(cells)
    free = len(cells) - PARAMETERS
    variance = float(away @ away) / free
    hidden = noise**2
    left = max(variance - hidden, 0.0)
    # of a variance with so many degrees of freedom; and noise is known to a fifth of its variance
    sd = math.hypot(variance * math.sqrt(2 / free), 0.2 * hidden)
    return Estimate(math.sqrt(left), sd / (2 * math.sqrt(max(left, sd))))


def _cells(contact: Contact) -> tuple[Array, float]:
    """Return the means (n, 3) of points in cells inside the rim, m, and the noise of a mean."""
    points = np.asarray(contact.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InvalidInput(f"contact points have shape (n, 3), got {points.shape}")
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        raise IllConditioned("the contact has no point with a depth")
    middle = np.median(points[:, :2], axis=0)
    far = np.hypot(*(points[:, :2] - middle).T)
    points = points[far <= RIM * math.sqrt(2.0 * float(np.mean(far**2)))]
    _, which, counts = np.unique(np.floor(points[:, :2] / CELL), axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    sums = np.column_stack([np.bincount(which, points[:, k], len(counts)) for k in range(3)])
    full = counts >= LEAST_PIXELS
    pixels = float(counts[full].mean()) if full.any() else 1.0
    alike = min(contact.noise_area / pixels, 1.0) if contact.noise_area > 1 else 1.0 / pixels
    return sums[full] / counts[full, None], float(contact.noise) * math.sqrt(alike)


def _from_sphere(points: Array) -> Array:
    """Return the distances (n,) of points from the sphere that fits them best in the sense of least squares, m."""
    centred = points - points.mean(axis=0)
    size = float(np.abs(centred).max())
    scaled = centred / size
    # z + k |p|^2 / 2 + a x + b y + c = 0 has no preference for small spheres, unlike |p|^2 = 2 m p + d
    design = np.column_stack([np.ones(len(scaled)), scaled[:, :2], (scaled**2).sum(axis=1)])
    fit, *_ = np.linalg.lstsq(design, scaled[:, 2], rcond=None)
    slope = np.column_stack(
        [-fit[1] - 2 * fit[3] * scaled[:, 0], -fit[2] - 2 * fit[3] * scaled[:, 1], 1 - 2 * fit[3] * scaled[:, 2]]
    )
    return np.asarray(size * (scaled[:, 2] - design @ fit) / np.linalg.norm(slope, axis=1))
