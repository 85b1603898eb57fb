"""The sphere under a contact: cap and skirt together say where the membrane leaves it, the cap alone how round it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.deprojection import view_rays
from stretch_bt.perception.shapes.noise_area import surface_noise
from stretch_bt.perception.shapes.robust_fit import robust_linear, settle
from stretch_bt.perception.shapes.sight import Sight, camera_of, sighted
from stretch_bt.perception.shapes.sphere import fit_sphere
from stretch_bt.perception.shapes.sphere_kernel import fill_cap
from stretch_bt.perception.types import Contact, FloatArray, Sphere

__all__ = ["CapSurface", "Rim", "fit_contact_sphere", "find_rim"]

Array = npt.NDArray[np.float64]

PARAMETERS = 8
INSIDE = 0.9  # share of the rim's size within which the membrane touches, whatever its skirt is like
SKIRT = 1.3  # rims away from the middle up to which the skirt is described by its curvature at the rim
CORE = 0.7  # rims from the middle that a start is taken from
CELLS = 500  # in which the cap and its skirt are averaged
LARGEST = 4.0  # times the contact as segmented, beyond which what is found is something else
ROUNDS = 10
STEPS = 8  # in a round: the rim need not be better than what the next round looks at
SETTLED = 0.02  # relative change of the rim
LARGEST_CHANGE = 0.25  # relative, of the rim in one step


@dataclass(frozen=True, slots=True)
class Rim:
    """Where a membrane leaves a sphere, seen along z: an ellipse about (x, y) with semi-axes a along i, b along j, m."""

    x: float
    y: float
    a: float
    b: float

    def distance(self, points: FloatArray) -> Array:
        """Return the distance (...) of points (..., 3) from the middle in rims: 1 on it; NaN for points that are NaN."""
        return np.asarray(np.hypot((points[..., 0] - self.x) / self.a, (points[..., 1] - self.y) / self.b))


def fit_contact_sphere(contact: Contact) -> Sphere:
    """Fit a sphere to what of a contact's surface touches it for certain, by the skirt around it.

    The segmentation only says where to look; the sphere is fitted within nine tenths of the rim that `find_rim` finds.
    Its standard deviations take the noise, and over how many pixels it is alike, from the frame where this shows more
    than the contact.

    Raises
    ------
    IllConditioned
        As for `fit_sphere`, or the surface is concave.
    """
    points, rays = _touching(contact)
    sphere = fit_sphere(points, rays=rays, noise=surface_noise(contact.surface) or contact.noise)
    if sphere.curvature < 0.0:
        raise IllConditioned("the surface is concave where the contact should be: nothing round is pressed into it")
    return sphere


def _touching(contact: Contact) -> tuple[FloatArray, FloatArray]:
    """Return the points (n, 3) that touch for certain, and their rays; as segmented where no skirt shows a rim."""
    try:
        rim = find_rim(contact)
    except IllConditioned:
        return contact.points, contact.rays
    with np.errstate(invalid="ignore"):
        points = contact.surface[rim.distance(contact.surface) < INSIDE]
    eye = camera_of(contact.points, contact.rays)
    if eye is None:
        return points, np.broadcast_to(contact.rays.mean(axis=0, keepdims=True), points.shape)
    return points, view_rays(points, tuple(eye))


def find_rim(contact: Contact) -> Rim:
    """Return where the membrane leaves a sphere, from the surface around a contact.

    Raises
    ------
    IllConditioned
        The surface around the contact does not tell where the rim is.
    """
    x, y = np.median(contact.points[:, :2], axis=0)
    a, b = 2.0 * contact.points[:, :2].std(axis=0)
    rim = Rim(float(x), float(y), float(a), float(b))
    middle = np.array([x, y, 0.0])
    for _ in range(ROUNDS):
        rim, before = _refined(contact.surface, rim), rim
        if max(abs(rim.a / before.a - 1.0), abs(rim.b / before.b - 1.0)) < SETTLED:
            break
    if rim.distance(middle) > 1.0 or rim.a > LARGEST * a or rim.b > LARGEST * b:
        raise IllConditioned("the rim that the surface shows is not that of the contact")
    return rim


def _refined(surface: FloatArray, rim: Rim) -> Rim:
    """Return the rim after a fit to the surface within SKIRT of it; it may grow up to there."""
    sight = sighted(_cells(surface, rim), None, None, name="sphere", least=PARAMETERS + 1)
    at = (np.array([rim.x, rim.y]) - sight.origin[:2]) / sight.size
    axes = np.array([rim.a, rim.b]) / sight.size
    start = np.concatenate([_paraboloid(sight, at, CORE * axes), np.log(axes), at])
    q = settle(CapSurface(start, np.log(SKIRT * axes)), sight, "sphere", steps=STEPS).surface.q
    x, y = q[6:] * sight.size + sight.origin[:2]
    a, b = np.exp(q[4:6]) * sight.size
    return Rim(float(x), float(y), float(a), float(b))


def _cells(surface: FloatArray, rim: Rim) -> Array:
    """Return the means (m, 3), m, of square blocks of pixels within SKIRT rims, about CELLS of them."""
    with np.errstate(invalid="ignore"):
        near = rim.distance(surface) < SKIRT
    rows, columns = (np.flatnonzero(near.any(axis=k)) for k in (1, 0))
    if not rows.size:
        raise IllConditioned("there is no surface around the contact")
    window = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    side = max(1, round((float(near.sum()) / CELLS) ** 0.5))
    points = np.where(near[window][..., None], surface[window], np.nan).astype(np.float64)
    height, width = (-(-n // side) for n in points.shape[:2])
    padded = np.full((height * side, width * side, 3), np.nan)
    padded[: points.shape[0], : points.shape[1]] = points
    blocks = padded.reshape(height, side, width, side, 3).transpose(0, 2, 1, 3, 4).reshape(-1, side * side, 3)
    seen = np.isfinite(blocks[..., 2])
    half = 2 * seen.sum(axis=1) >= side * side
    return np.asarray(np.where(seen[half][..., None], blocks[half], 0.0).sum(axis=1) / seen[half].sum(axis=1)[:, None])


def _paraboloid(sight: Sight, at: Array, axes: Array) -> Array:
    """Return (c, p1, p2, k) of a convex paraboloid about the core of a contact, to start from."""
    core = np.hypot((sight.x - at[0]) / axes[0], (sight.y - at[1]) / axes[1]) < 1.0
    x, y = sight.x[core], sight.y[core]
    if x.size <= PARAMETERS:
        raise IllConditioned("the contact is smaller than what its skirt can be told from")
    design = np.stack([np.ones_like(x), x, y, -0.5 * (x * x + y * y)])
    q, _ = robust_linear(design, sight.z[core], sight.floor, "sphere")
    q[3] = np.clip(q[3], 0.05, 0.9 / float(np.hypot(sight.x, sight.y).max()))
    return q


@dataclass(frozen=True, slots=True)
class CapSurface:
    """A sphere inside an ellipse; outside it the membrane that leaves it there with the same slope and no mean curvature.

    `q` (8,) is (c, p1, p2, k) of a SphereSurface, the logarithms of the semi-axes along x and y, and the middle. Beyond
    the rim, along the ray from the middle, z continues by its second derivatives: those of the sphere plus a jump J n n
    across the rim's normal n, which continuity of slope leaves as the only one (Hadamard's compatibility condition),
    with J such that their trace vanishes, as it does on a membrane that nothing touches. `most` (2,) are the logarithms
    of the largest semi-axes.
    """

    q: Array
    most: Array

    @property
    def parameters(self) -> int:
        """How many parameters there are."""
        return PARAMETERS

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (8, n)."""
        height, jacobian = np.empty(x.size), np.empty((PARAMETERS, x.size))
        fill_cap(self.q, x, y, height, jacobian)
        return height, jacobian

    def moved(self, step: Array) -> tuple[CapSurface, Array]:
        """Return the surface after a step, shortened where the rim or the curvature would change by much."""
        change = max(float(np.abs(step[4:6]).max()), float(np.abs(step[6:] / np.exp(self.q[4:6])).max()))
        share = min(
            1.0,
            LARGEST_CHANGE / max(change, 1e-300),
            0.5 * max(abs(float(self.q[3])), 0.05) / max(abs(float(step[3])), 1e-300),
        )
        q = self.q + share * step
        q[4:6] = np.minimum(q[4:6], self.most)
        return replace(self, q=q), q - self.q
