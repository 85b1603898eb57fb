"""Flat faces in a cloud, by robust plane fits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.cloud import Array, Cloud
from stretch_bt.perception.robust import TUKEY, scale_of, tukey_weights

__all__ = ["CloudFace", "find_faces", "settled"]

PATCH = 40  # points of the first guess of a plane
GUESSES = 120
FEWEST = 60  # points
LEAST_WIDTH = 3e-3  # m; narrower ones are what a membrane leaves of an edge
BAND = 3.5  # standard deviations to either side of a plane within which points can be of it
TURN = np.cos(np.radians(35.0))  # cosine of the largest angle between a point's normal and its face's
CENTRAL = 0.35  # share of its width to either side of a face's middle in which it is flat if it is one
BOW, SURE, STRAIGHT = 0.2, 3.5, 2e-5  # of the scatter, standard deviations, and m: a face bows by less over that
BESIDE, STRIP = 2e-3, 0.35  # m, and the share of a face that may lie so near a curved surface that it passes into
GRAZING = 0.2  # share of its noise that a point seen along a face still has across it
GRID, BORDER = 1e-3, 2  # m, and cells of it along the border of a face that are left out
LAG, REACH = 0.5e-3, 25  # m, and how many of it the errors of two points are compared over
EFFICIENCY = np.sqrt(0.95)  # of Tukey's weights on Gaussian noise, as a deviation
VANISHED = 0.1  # correlation that is taken for none


@dataclass(frozen=True, slots=True)
class CloudFace:
    """A plane with the points that lie in it.

    `normal` (3,) points out of the object, `middle` (3,), m, is the mean of its points and `frame` (2, 3) spans it.
    `covariance` (3, 3) is the covariance of its height over the middle, m, and its two slopes along `frame`.
    """

    normal: Array
    middle: Array
    frame: Array
    covariance: Array
    members: npt.NDArray[np.bool_]
    width: float

    def height(self, place: Array, along: Array) -> tuple[float, float]:
        """Return how far the plane is from a place along a direction, m, and the standard deviation of that."""
        lean = float(self.normal @ along)
        away = float(self.normal @ (self.middle - place)) / lean
        at = self.frame @ (place + away * along - self.middle)
        row = np.array([1.0, *at])
        return away, float(np.sqrt(row @ self.covariance @ row)) / abs(lean)


def settled(points: Array, count: int) -> tuple[Array, Array]:
    """Return each point (n, 3) moved onto the plane through its nearest `count` points, and the normal (n, 3) of that."""
    from scipy.spatial import cKDTree

    _, near = cKDTree(points).query(points, k=min(count, len(points)))
    around = points[near]
    means = around.mean(axis=1)
    away = around - means[:, None]
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", away, away))
    normals = vectors[:, :, 0]
    return points + normals * np.einsum("ij,ij->i", means - points, normals)[:, None], normals


@dataclass(frozen=True, slots=True)
class _Seen:
    """The points of a cloud with unit normals (n, 3) out of the object, and what each fit of a plane asks of them.

    `scatter` (n,), m, is the standard deviation along the rays, `least` (n,), m, the least one across them.
    """

    points: Array
    rays: Array
    normals: Array
    scatter: Array
    least: Array

    @classmethod
    def of(cls, cloud: Cloud, normals: Array) -> _Seen:
        least = np.maximum(GRAZING * cloud.noise, cloud.floor)
        return cls(cloud.points, cloud.rays, normals, cloud.scatter_sd, least)

    def part(self, kept: npt.NDArray[Any]) -> _Seen:
        return _Seen(self.points[kept], self.rays[kept], self.normals[kept], self.scatter[kept], self.least[kept])

    def across(self, normal: Array) -> Array:
        """Return the standard deviation of each point along a normal: that along its ray, and at least a part of it."""
        return np.hypot(self.scatter * np.abs(self.rays @ normal), self.least)


@dataclass(frozen=True, slots=True)
class _Fit:
    """A plane through members, with the data for its covariance: most planes that are tried need none."""

    normal: Array
    middle: Array
    frame: Array
    members: npt.NDArray[np.bool_]
    width: float
    design: Array
    known: Array
    left: Array
    used: npt.NDArray[np.bool_]

    def face(self) -> CloudFace:
        covariance = _covariance(self.design, self.known, self.left, self.used)
        return CloudFace(self.normal, self.middle, self.frame, covariance, self.members, self.width)


def find_faces(cloud: Cloud, normals: Array) -> list[CloudFace]:
    """Return the flat faces of a cloud, the largest first; `normals` (n, 3) are unit vectors out of the object."""
    seen = _Seen.of(cloud, normals)
    left = np.ones(len(cloud), dtype=bool)
    bowed = np.zeros(len(cloud), dtype=bool)
    found: list[CloudFace] = []
    while left.sum() >= FEWEST:
        face = _largest(seen, left)
        if face is None:
            break
        left &= ~face.members
        if face.width < LEAST_WIDTH:
            continue
        if _is_bowed(seen, face) or _goes_on(seen, face, bowed):
            bowed |= face.members
        else:
            found.append(_inner(seen, face).face())
    return sorted(found, key=lambda face: -int(face.members.sum()))


def _largest(seen: _Seen, left: npt.NDArray[np.bool_]) -> _Fit | None:
    """Return the plane in which most of the points lie that are left, or None when no plane has enough."""
    some = np.flatnonzero(left)
    some = some[:: max(1, len(some) // 4000)]
    points, outward, sd = seen.points[some], seen.normals[some], seen.scatter[some]
    seeds = np.linspace(0, len(some) - 1, min(GUESSES, len(some))).astype(np.int64)
    # The distance of every point from the plane through every seed across its normal, in standard deviations.
    away = (points @ outward[seeds].T - np.einsum("ij,ij->i", points[seeds], outward[seeds])) / sd[:, None]
    fits = np.maximum(1.0 - (away / (2.0 * BAND)) ** 2, 0.0) * (outward @ outward[seeds].T > TURN)
    best = seeds[int(fits.sum(axis=0).argmax())]
    members = left & _near(seen, outward[best], points[best], 2.0 * BAND)
    face = None
    for _ in range(12):
        if members.sum() < FEWEST:
            return None
        face = _fitted(seen, members)
        again = left & _near(seen, face.normal, face.middle, BAND)
        if (again == members).all():
            break
        members = again
    return face


def _near(seen: _Seen, normal: Array, middle: Array, band: float) -> npt.NDArray[np.bool_]:
    """Return which points lie in a band about a plane and face as it does."""
    close = np.abs((seen.points - middle) @ normal) <= band * seen.across(normal)
    return np.asarray(close & (seen.normals @ normal > TURN))


def _fitted(seen: _Seen, members: npt.NDArray[np.bool_]) -> _Fit:
    """Return the plane through members by reweighted least squares along its own normal, with Tukey's weights."""
    near = seen.part(members)
    points = near.points
    middle = points.mean(axis=0)
    extent, vectors = np.linalg.eigh((points - middle).T @ (points - middle) / len(points))
    normal, frame = vectors[:, 0], vectors[:, :0:-1].T
    if normal @ near.normals.sum(axis=0) < 0:
        normal = -normal
    known = 1.0 / near.across(normal)
    weights = np.ones(len(points))
    for _ in range(8):
        design = np.column_stack([np.ones(len(points)), (points - middle) @ frame.T])
        height = (points - middle) @ normal
        weighted = design * (weights * known**2)[:, None]
        inverse = np.linalg.pinv(weighted.T @ design)
        fit = inverse @ (weighted.T @ height)
        left = height - design @ fit
        normal = normal - frame.T @ fit[1:]
        normal /= np.linalg.norm(normal)
        frame = np.linalg.qr(np.column_stack([normal, frame.T]))[0][:, 1:].T
        middle = middle + normal * fit[0]
        scaled = left * known
        weights = tukey_weights(scaled / (TUKEY * max(scale_of(scaled, 3), 1e-3)))
    width = float(np.sqrt(12.0 * max(extent[1], 0.0)))
    return _Fit(normal, middle, frame, members, width, design, known, left, weights > 0)


def _covariance(design: Array, known: Array, left: Array, used: npt.NDArray[np.bool_]) -> Array:
    """Return the covariance of a Tukey fit of points with inverse deviations `known`, wider as near points err alike."""
    design, known, left = design[used], known[used], left[used]
    sd = scale_of(left * known, 3) / EFFICIENCY
    inverse = np.linalg.pinv((design * (known * known)[:, None]).T @ design)
    return np.asarray(inverse * sd * sd * _alike(design[:, 1:], left))


def _alike(places: Array, left: Array) -> float:
    """Return how many points of a plane err as one: the sum of the autocorrelation of a fit's residuals, over the plane.

    It is summed up to where it vanishes. The fit takes up errors that vary more slowly than the face is wide: these are not seen.
    """
    cells = np.floor((places - places.min(axis=0)) / LAG).astype(np.int64)
    shape = tuple(2 * (cells.max(axis=0) + 1))
    known, seen = np.zeros(shape), np.zeros(shape)
    np.add.at(known, tuple(cells.T), left / np.sqrt(np.mean(left**2)) if left.any() else left)
    np.add.at(seen, tuple(cells.T), 1.0)
    products, pairs = (np.fft.irfft2(np.abs(np.fft.rfft2(v)) ** 2, s=shape) for v in (known, seen))
    lags = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n, 1.0 / n) for n in shape), indexing="ij"))
    ring = np.rint(lags).astype(np.int64).ravel()
    product, pair = (np.bincount(ring, v.ravel())[:REACH] for v in (products, pairs))
    gone = np.flatnonzero(product[1:] <= VANISHED * pair[1:])
    last = 1 + int(gone[0]) if len(gone) else len(product)
    return max(float(product[:last].sum()) / len(left), 1.0)


def _is_bowed(seen: _Seen, face: _Fit) -> bool:
    """Whether the middle of the members follows a curve: a quadratic rises by much over half their width, and surely."""
    points = seen.points[face.members] - face.middle
    x, y = (points @ face.frame.T).T
    central = (np.abs(x) < CENTRAL * np.sqrt(12.0 * np.var(x))) & (np.abs(y) < CENTRAL * np.sqrt(12.0 * np.var(y)))
    x, y, z = x[central], y[central], (points @ face.normal)[central]
    design = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    if len(z) < FEWEST // 2:
        return False
    fit, *_ = np.linalg.lstsq(design, z, rcond=None)
    left = z - design @ fit
    scatter = scale_of(left, 6)
    rise = 0.5 * (CENTRAL * face.width) ** 2
    alone = float(np.diag(np.linalg.pinv(design.T @ design))[3:].max())
    sd = scatter * rise * 2.0 * float(np.sqrt(alone * _alike(design[:, 1:3], left)))
    bend = float(np.abs(np.linalg.eigvalsh([[2 * fit[3], fit[4]], [fit[4], 2 * fit[5]]])).max())
    return bend * rise > max(BOW * scatter, SURE * sd, STRAIGHT)


def _goes_on(seen: _Seen, face: _Fit, bowed: npt.NDArray[np.bool_]) -> bool:
    """Whether much of a face passes into a curved surface without an edge: it is a strip of that."""
    from scipy.spatial import cKDTree

    curved = np.flatnonzero(bowed)
    if not len(curved):
        return False
    found = cKDTree(seen.points[curved]).query(seen.points[face.members], distance_upper_bound=BESIDE)
    away, near = np.asarray(found[0]), np.asarray(found[1])
    close = np.isfinite(away)
    alike = np.einsum("ij,ij->i", seen.normals[face.members][close], seen.normals[curved[near[close]]]) > TURN
    return float(alike.sum()) > STRIP * float(face.members.sum())


def _inner(seen: _Seen, face: _Fit) -> _Fit:
    """Return the face fitted without its border, which the membrane may have rounded; as it is where too little is left."""
    from scipy.ndimage import binary_closing, binary_erosion

    at = (seen.points[face.members] - face.middle) @ face.frame.T
    cells = np.floor((at - at.min(axis=0)) / GRID).astype(np.int64) + 2
    covered = np.zeros(cells.max(axis=0) + 3, dtype=bool)
    covered[tuple(cells.T)] = True
    whole = binary_erosion(binary_closing(covered), iterations=BORDER)
    members = np.zeros_like(face.members)
    members[np.flatnonzero(face.members)[whole[tuple(cells.T)]]] = True
    if members.sum() < FEWEST:
        return face
    inner = _fitted(seen, members)
    return inner if inner.width >= LEAST_WIDTH / 2 else face
