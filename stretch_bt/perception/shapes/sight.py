"""Points as the camera sees them: checked, freed of copies, in a frame whose z runs towards the camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.frames import as_numbers
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.types import FloatArray, SurfaceNoise
from stretch_bt.plain_numbers import is_number

__all__ = ["Noise", "Sight", "camera_of", "extent", "sighted"]

Array = npt.NDArray[np.float64]
Noise = float | SurfaceNoise | None  # standard deviation of one point, m, and over how many points it is alike

THIN = 1e-5  # width over length, seen from the camera, below which points lie on a line
PARALLEL = 1e-6  # slope between rays below which they count as parallel
STEEPEST_RAY = 0.1  # least cosine between a ray and their mean
DIGITS = 4.0  # units in the last place of the largest coordinate below which nothing is resolved


@dataclass(frozen=True, slots=True)
class Sight:
    """Points (n,) as `x`, `y` across and `z` towards the camera, from `origin` and in units of `size`, m.

    `axes` (3, 3) has the frame's axes as rows, in the caller's frame; `origin` (3,), m, is in this frame. `floor` is the
    least standard deviation of z, in units of `size`: the noise, if known, or the `resolution` of the numbers. `alike` is
    over how many points noise is known to be alike, at least 1. `lean` (2, n) is how far each point's own ray moves x
    and y for every z; None where all rays are parallel.
    """

    x: Array
    y: Array
    z: Array
    lean: Array | None
    axes: Array
    origin: Array
    size: float
    floor: float
    resolution: float
    alike: float

    def moved_to(self, residuals: Array) -> Sight:
        """Return the points with x and y where their rays come down by `residuals` (n,), the heights of z above a surface."""
        assert self.lean is not None
        x, y = np.stack([self.x, self.y]) - self.lean * residuals
        return replace(self, x=x, y=y)

    def place(self, local: Array) -> Array:
        """Return a point of this frame (3,), in units of `size`, in the caller's frame, m."""
        return np.asarray(self.axes.T @ (local * self.size + self.origin))

    def direction(self, local: Array) -> Array:
        """Return a direction of this frame (3,) in the caller's frame."""
        return np.asarray(self.axes.T @ local)

    def spread(self, by_parameters: Array, covariance: Array) -> Array:
        """Return the standard deviation (3,) in the caller's frame of what depends on parameters by (3, p)."""
        rotated = self.axes.T @ by_parameters
        return np.asarray(np.sqrt(np.einsum("ij,jk,ik->i", rotated, covariance, rotated).clip(0.0)))


def sighted(points: FloatArray, rays: FloatArray | None, noise: Noise, *, name: str, least: int) -> Sight:
    """Prepare points (n, 3), m, for a fit along the rays; `name` is the shape's name, `least` how many points it needs.

    Raises
    ------
    IllConditioned
        There are fewer than `least` distinct finite points, or the camera sees them on one line or at one place.
    InvalidInput
        An array has the wrong shape or holds no numbers, or the noise is not a positive number.
    """
    known = _known(noise)
    kept, directions = _checked(points, rays, name)
    if len(kept) < least:
        raise IllConditioned(
            f"a {name} with its error needs at least {least} distinct points, there are {len(kept)}; press deeper, so that more of the"
            " membrane touches"
        )
    axes = _axes(directions)
    local = axes @ kept.T
    origin = np.array([quantile(row) for row in local])
    local -= origin[:, None]
    magnitude = float(np.abs(kept).max())
    size = _lateral_size(local[0], local[1], magnitude)
    x, y, z = local / size
    resolution = DIGITS * _resolution(points) * magnitude / size
    lean = _lean(directions @ axes.T)
    return Sight(x, y, z, lean, axes, origin, size, max(known.sd / size, resolution), resolution, known.area)


def _lean(directions: Array) -> Array | None:
    """Return how far rays (n, 3) move x and y for every z; None where they hardly do."""
    lean = directions[:, :2].T / np.minimum(directions[:, 2], -STEEPEST_RAY)
    return lean if np.abs(lean).max() > PARALLEL else None


def camera_of(points: FloatArray, rays: FloatArray) -> Array | None:
    """Return the place (3,), m, where rays (n, 3) through points (n, 3), m, come nearest to meeting; None if parallel."""
    across = np.eye(3) - rays[:, :, None] * rays[:, None, :]
    total = across.sum(axis=0)
    if np.linalg.eigvalsh(total)[0] < PARALLEL * len(points):
        return None
    return np.asarray(np.linalg.solve(total, np.einsum("nij,nj->i", across, points)))


def _known(noise: Noise) -> SurfaceNoise:
    if isinstance(noise, SurfaceNoise):
        return noise
    if noise is not None and not (is_number(noise) and noise > 0.0):
        raise InvalidInput(f"noise is a positive standard deviation in m, or a SurfaceNoise, got {shown(noise)[:80]}")
    return SurfaceNoise(noise or 0.0, 1.0)


def _resolution(points: FloatArray) -> float:
    """Return the relative resolution of the caller's numbers, exact for integers and lists."""
    kind = np.asarray(points).dtype
    return float(np.finfo(kind if kind.kind == "f" else np.float64).eps)


def _checked(points: FloatArray, rays: FloatArray | None, name: str) -> tuple[Array, Array]:
    array = _floats(points, f"points for a {name} are")
    if rays is None:
        directions = np.broadcast_to(np.array([0.0, 0.0, -1.0]), array.shape)
    else:
        directions = _floats(rays, "rays are")
        if directions.shape != array.shape:
            raise InvalidInput(f"rays need the shape of the points, {array.shape}, got {directions.shape}")
    finite = np.isfinite(array) & np.isfinite(directions)
    if not finite.all():
        kept = finite.all(axis=1)
        array, directions = array[kept], directions[kept]
    return _distinct(array, directions)


def _floats(values: FloatArray, what: str) -> Array:
    array = as_numbers(what, values)
    if array.dtype.kind not in "fiu" or array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(f"{what} numbers of shape (n, 3) in m, got {array.dtype} {array.shape}")
    return array.astype(np.float64)


def _distinct(points: Array, directions: Array) -> tuple[Array, Array]:
    """Drop repeated points: they carry no information and would make the error look smaller than it is."""
    key = np.sort(points @ np.array([1.0, np.sqrt(2.0), np.sqrt(3.0)]))
    if (key[1:] != key[:-1]).all():
        return points, directions
    order = np.lexsort(points.T)
    ranked = points[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    return ranked[first], directions[order][first]


def _axes(directions: Array) -> Array:
    """Return the (3, 3) rotation whose third row points from the surface to the camera."""
    mean = -directions.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if length < 0.1:
        raise InvalidInput("rays are unit vectors from one camera; these point in opposite directions")
    z = mean / length
    x = np.array([z[2], 0.0, -z[0]] if abs(z[1]) < 0.9 else [-z[1], z[0], 0.0])
    x /= np.linalg.norm(x)
    y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]]
    return np.array([x, y, z])


def extent(x: Array, y: Array) -> tuple[float, float]:
    """Return the standard deviations of places (n,) along the narrowest and the widest direction."""
    x, y = x - x.mean(), y - y.mean()
    xx, xy, yy = float(x @ x) / x.size, float(x @ y) / x.size, float(y @ y) / x.size
    half, apart = (xx + yy) / 2.0, math.hypot((xx - yy) / 2.0, xy)
    return math.sqrt(max(half - apart, 0.0)), math.sqrt(half + apart)


def _lateral_size(x: Array, y: Array, magnitude: float) -> float:
    """Return the rms distance from the origin across the rays, or refuse points on a line or at one place."""
    narrow, wide = extent(x, y)
    if wide <= 1e-13 * magnitude or wide == 0.0:
        raise IllConditioned(
            "all points lie on one line of sight, which shows no shape; give points from more than one pixel"
        )
    if narrow < THIN * wide:
        raise IllConditioned(
            "the points lie on one line as the camera sees them, which shows no shape across it; press deeper, so that an area touches"
        )
    return float(np.hypot(narrow, wide))
