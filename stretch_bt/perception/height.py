"""Height of the object's top: the vertex of a quadratic on a curved top, a robust mean on a flat one."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception.robust import TUKEY, quantile, scale_of, tukey_psi_slope, tukey_weights
from stretch_bt.perception.surface import check_points
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["top_of_points", "track_height"]

Array = npt.NDArray[np.float64]

RIM = 0.75  # share of the contact's radius that the membrane's bend at the rim leaves alone
REACH = 0.35  # share of the radius of curvature within which a quadratic is a sphere to a thousandth of the radius


def track_height(points: FloatArray, valid: MaskArray, labels: LabelArray) -> Estimate:
    """Return the height of the object's top, z of the membrane frame, m.

    Parameters
    ----------
    points : (h, w, 3) float, m, membrane frame
    valid : (h, w) bool
    labels : (h, w) uint8
        Classes as `segment` gives them, of this frame or of an earlier one with the same contact.

    Returns
    -------
    Estimate
        Its standard deviation is that of noise independent from pixel to pixel.

    Raises
    ------
    NoContact
        No valid pixel is in contact.
    IllConditioned
        Too few pixels for a height with its error.
    """
    check_points(points, valid)
    if labels.shape != valid.shape:
        raise InvalidInput(f"labels need the shape of the frame, {valid.shape}, got {labels.shape}")
    return top_of_points(points[valid & (labels == CONTACT)])


def top_of_points(points: FloatArray) -> Estimate:
    """Return the height, m, of the top of contact points (n, 3), m, membrane frame; raises as `track_height`."""
    cloud = np.asarray(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise InvalidInput(f"contact points have shape (n, 3), got {cloud.shape}")
    cloud = cloud[np.isfinite(cloud).all(axis=1)]
    if not len(cloud):
        raise NoContact("there is no valid point in contact")
    if len(cloud) < 12:
        raise IllConditioned(f"a height with its error needs at least twelve points in contact, there are {len(cloud)}")
    x, y, z = np.ascontiguousarray(cloud.T)
    middle = np.array([quantile(x), quantile(y)])
    away = (x - middle[0]) ** 2 + (y - middle[1]) ** 2
    radius = float(np.sqrt(2.0 * quantile(away)))
    kept = _disc(away, RIM * radius)
    top = _Top(x[kept], y[kept], z[kept], middle)
    if not top.is_curved:
        return _flat(z[kept])
    for _ in range(2):
        reach = min(RIM * radius, max(REACH / top.curvature, 0.3 * radius))
        vertex = top.vertex(radius)
        disc = _disc((x - vertex[0]) ** 2 + (y - vertex[1]) ** 2, reach)
        if disc.sum() == len(x) or np.array_equal(disc, kept):
            break
        kept = disc
        top = _Top(x[kept], y[kept], z[kept], vertex)
        if not top.is_curved:
            return _flat(z[kept])
    return top.estimate(radius)


def _disc(away: Array, radius: float) -> MaskArray:
    """Return which squared distances lie within a radius, or all where that leaves too few."""
    near = away <= radius * radius
    return near if near.sum() >= 12 else np.ones(len(away), dtype=bool)


def _flat(z: Array) -> Estimate:
    """Return Tukey's robust mean and its standard deviation."""
    center = quantile(z)
    scale = max(scale_of(z - center, 1), 1e-12)
    for _ in range(5):
        before = center
        weights = tukey_weights((z - center) / (TUKEY * scale))
        center = float(weights @ z / weights.sum())
        if abs(center - before) < 1e-3 * scale / len(z) ** 0.5:
            break
    return Estimate(center, _m_sd((z - center) / (TUKEY * scale), 1) * TUKEY * scale / float(np.sqrt(len(z))))


def _m_sd(u: Array, parameters: int) -> float:
    """Return how much wider than 1/sqrt(n) an M-estimate spreads, in units of the cut (Huber, 1981, section 7.6)."""
    inside = np.abs(u) < 1.0
    psi = u[inside] * tukey_weights(u[inside])
    count = max(int(inside.sum()), parameters + 1)
    spread = float(psi @ psi) / (count - parameters)
    return float(np.sqrt(spread * len(u) / count)) / max(float(tukey_psi_slope(u[inside]).mean()), 0.1)


def _solve(normal: Array, right: Array) -> Array:
    try:
        solution: Array = np.linalg.solve(normal, right)
    except np.linalg.LinAlgError as error:
        raise IllConditioned("the points in contact lie on one line") from error
    return solution


class _Top:
    """z = c + b . (x, y) - (kx x^2 + 2 kxy x y + ky y^2) / 2 about `middle`, fitted with Tukey's weights."""

    def __init__(self, x: Array, y: Array, z: Array, middle: Array) -> None:
        self.middle = middle
        x, y = x - middle[0], y - middle[1]
        self.size = max(float(np.sqrt((x @ x + y @ y) / len(x))), 1e-12)
        x, y = x / self.size, y / self.size
        design = np.stack([np.ones_like(x), x, y, -0.5 * x * x, -x * y, -0.5 * y * y])
        offset = quantile(z)
        z = z - offset
        normal = design @ design.T
        if np.linalg.cond(normal) > 1e12:
            raise IllConditioned("the points in contact lie on one line")
        self.q = _solve(normal, design @ z)
        for _ in range(8):
            residuals = z - self.q @ design
            scale = max(scale_of(residuals, 6), 1e-12)
            weighted = design * tukey_weights(residuals / (TUKEY * scale))
            before = self.q
            self.q = _solve(weighted @ design.T, weighted @ z)
            if np.abs(self.q - before).max() < 0.01 * scale / len(z) ** 0.5:
                break
        residuals = z - self.q @ design
        sd = _m_sd(residuals / (TUKEY * scale), 6) * TUKEY * scale
        self.covariance: Array = np.linalg.inv(normal) * sd * sd
        self.q[0] += offset

    @property
    def curvature(self) -> float:
        """Mean curvature, 1/m."""
        return float(self.q[3] + self.q[5]) / 2.0 / self.size**2

    @property
    def is_curved(self) -> bool:
        """Whether it is convex in every direction and significantly so."""
        both = np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.5])
        sd = float(np.sqrt(both @ self.covariance @ both))
        kx, kxy, ky = self.q[3:]
        return bool(both @ self.q > 3.0 * sd and kx > 0.0 and ky > 0.0 and kx * ky > kxy * kxy)

    def _offset(self, most: float) -> Array:
        """Return the vertex from the middle in units of `size`, at most `most` metres away."""
        kx, kxy, ky = self.q[3:]
        step: Array = np.linalg.solve([[kx, kxy], [kxy, ky]], self.q[1:3])
        return step * min(1.0, most / self.size / max(float(np.linalg.norm(step)), 1e-300))

    def vertex(self, most: float) -> Array:
        """Return (x, y) of the vertex, m."""
        return self.middle + self.size * self._offset(most)

    def estimate(self, most: float) -> Estimate:
        """Return the height of the vertex; where it lies does not matter to first order."""
        x, y = self._offset(most)
        row = np.array([1.0, x, y, -0.5 * x * x, -x * y, -0.5 * y * y])
        return Estimate(float(row @ self.q), float(np.sqrt(row @ self.covariance @ row)))
