"""The dimensions of an object from a cloud: the distances of opposite faces, where it has such."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from stretch_bt.arguments import check_kind
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception.clouds.cloud import Array, Cloud
from stretch_bt.perception.clouds.faces import CloudFace, find_faces, settled
from stretch_bt.perception.types import CLOUD, FloatArray
from stretch_bt.units import Length

__all__ = ["Dimensions", "How", "measure_object"]

How = Literal["faces", "table", "extent"]

FEWEST = 100  # points
NEAREST = 25  # points from which a normal is taken
OPPOSITE = -np.cos(np.radians(10.0))
UPRIGHT = np.cos(np.radians(10.0))
APART = 0.5  # cosine of the least angle between two axes that are measured
EDGE = 2e-3  # m, radius
ENDS = 0.01  # share of the points at each end that an extent is taken from
WIDEST = 1.0  # m


@dataclass(frozen=True, slots=True)
class Dimensions:
    """Three dimensions of an object, m.

    `lengths` (3,) and `sd` (3,), m, along unit `axes` (3, 3), a row each: the third is the one nearest to z, the first
    the longer of the others. `how` says for each where it comes from: "faces" is the distance of two opposite faces,
    "table" the height of an upper face above the table, z = 0 of the world. "extent" is how far the points reach, the middle of
    the last of them; how gradually they end is part of its standard deviation. `short` (3,), m, is how far an extent
    falls short where the surface does not yet face along the axis at its ends, if an edge of 2 mm radius follows; it
    counts no surface that was never touched.
    """

    lengths: FloatArray
    sd: FloatArray
    axes: FloatArray
    how: tuple[How, How, How]
    short: FloatArray

    @property
    def length(self) -> Length:
        """The longer of the two dimensions across z, m."""
        return float(self.lengths[0])

    @property
    def width(self) -> Length:
        """The shorter of the two dimensions across z, m."""
        return float(self.lengths[1])

    @property
    def height(self) -> Length:
        """The dimension nearest to z, m."""
        return float(self.lengths[2])


@dataclass(frozen=True, slots=True)
class _Length:
    value: float
    sd: float
    axis: Array
    how: How
    short: float = 0.0


def measure_object(cloud: Cloud) -> Dimensions:
    """Return the dimensions of the object whose surface a cloud shows.

    Edges come out of a membrane rounded, so a dimension is the distance between planes fitted to opposite faces wherever
    both were felt. The standard deviation holds the noise, alike among near points, and the cloud's floor.

    Raises
    ------
    NoContact
        The cloud is empty.
    IllConditioned
        It has too few points, or they lie on one line.
    InvalidInput
        It is more than 1 m wide, as where its points are in millimetres.
    """
    check_kind("cloud", cloud, Cloud, CLOUD)
    if not len(cloud):
        raise NoContact("the cloud has no point: nothing was felt; press the object first")
    if len(cloud) < FEWEST:
        raise IllConditioned(
            f"the cloud has {len(cloud)} points; dimensions take at least {FEWEST}; press at more places"
        )
    spread = np.linalg.eigvalsh(np.cov(cloud.points.T))
    if spread[1] <= 1e-6 * spread[2] or spread[2] <= 0:
        raise IllConditioned(
            "the points of the cloud lie on one line, which shows one dimension only; press at more places"
        )
    wide = float(np.ptp(np.quantile(cloud.points, (ENDS, 1.0 - ENDS), axis=0), axis=0).max())
    if wide > WIDEST:
        raise InvalidInput(
            f"the points of a cloud are in metres; these are {wide:.3g} m wide, and an object is at most"
            f" {WIDEST:g} m: give them in metres"
        )
    surface, normals = settled(cloud.points, NEAREST)
    normals = np.where(np.einsum("ij,ij->i", normals, cloud.rays)[:, None] > 0, -normals, normals)
    faces = find_faces(cloud, normals)
    measured = _between_faces(cloud, faces)
    for axis in _axes(cloud, faces, measured, surface)[len(measured) :]:
        measured.append(_on_table(cloud, faces, axis) or _extent(cloud, surface, normals, axis))
    return _sorted(measured)


def _between_faces(cloud: Cloud, faces: list[CloudFace]) -> list[_Length]:
    """Return the distances of opposite faces along at most three axes, the largest faces first."""
    found: list[_Length] = []
    for one, other in combinations(faces, 2):
        if one.normal @ other.normal > OPPOSITE:
            continue
        axis = one.normal - other.normal
        axis /= np.linalg.norm(axis)
        middle = (one.middle + other.middle) / 2
        (up, up_sd), (down, down_sd) = one.height(middle, axis), other.height(middle, axis)
        distinct = all(abs(axis @ known.axis) < APART for known in found)
        if up - down > 0 and distinct and len(found) < 3:
            sd = float(np.sqrt(up_sd**2 + down_sd**2 + 2 * cloud.floor**2))
            found.append(_Length(up - down, sd, axis, "faces"))
    return found


def _axes(cloud: Cloud, faces: list[CloudFace], measured: list[_Length], surface: Array) -> list[Array]:
    """Return three axes: the measured ones, then the vertical and the normals of faces, in the world the vertical first.

    An axis that is not measured is perpendicular to the axes before it; where no face gives its direction, the smallest
    rectangle around the points does.
    """
    axes = [known.axis for known in measured]
    normals = [face.normal for face in faces]
    up = np.array([0.0, 0.0, 1.0])
    first = [up, *normals] if cloud.frame == "world" else [*normals, up]
    for candidate in first:
        if len(axes) < 3:
            basis = np.linalg.qr(np.array(axes).T)[0].T if axes else np.zeros((0, 3))
            free = candidate - basis.T @ (basis @ candidate)
            if np.linalg.norm(free) > 0.8:
                axes.append(free / np.linalg.norm(free))
    if len(axes) == 1:
        axes.append(_along_rectangle(surface, axes[0]))
    if len(axes) == 2:
        third = np.cross(axes[0], axes[1])
        axes.append(third / np.linalg.norm(third))
    return axes


def _along_rectangle(points: Array, axis: Array) -> Array:
    """Return the direction of the smallest rectangle around points, as seen along an axis."""
    import cv2

    one = np.linalg.svd(axis[None])[2][1]
    other = np.cross(axis, one)
    flat = np.column_stack([points @ one, points @ other])
    flat -= flat.mean(axis=0)
    angle = np.radians(cv2.minAreaRect((flat / np.abs(flat).max()).astype(np.float32))[2])
    return np.asarray(np.cos(angle) * one + np.sin(angle) * other)


def _on_table(cloud: Cloud, faces: list[CloudFace], axis: Array) -> _Length | None:
    """Return the height of the largest upper face above the table, where the axis is vertical and the world is known."""
    if cloud.frame != "world" or abs(axis[2]) < UPRIGHT:
        return None
    for face in faces:
        if face.normal[2] > UPRIGHT:
            up, sd = face.height(np.array([*face.middle[:2], 0.0]), np.array([0.0, 0.0, 1.0]))
            if up > 0:
                return _Length(up, float(np.hypot(sd, _floor_of_heights(cloud))), axis, "table")
    return None


def _extent(cloud: Cloud, surface: Array, normals: Array, axis: Array) -> _Length:
    """Return how far the settled points reach along an axis; in the world, a vertical extent counts from the table."""
    high, high_sd, short = _end(surface, normals, axis)
    if cloud.frame == "world" and axis[2] > UPRIGHT and high > 0:
        low, low_sd, floor = 0.0, 0.0, _floor_of_heights(cloud)
    else:
        low, low_sd, more = _end(surface, normals, -axis)
        short, floor = short + more, cloud.floor
    noise = float(np.median(cloud.noise)) / np.sqrt(NEAREST)
    sd = float(np.sqrt(high_sd**2 + low_sd**2 + 2 * noise**2 + 2 * floor**2))
    return _Length(high + low, sd, axis, "extent", short)


def _floor_of_heights(cloud: Cloud) -> float:
    """Return the standard deviation, m, that all heights above the table share: the floor and the least of the other errors."""
    felt = (
        None if cloud.apart is None else cloud.apart[cloud.seen > 0]
    )  # points that were inferred have an error of their own
    return cloud.floor if felt is None or not felt.size else float(np.hypot(cloud.floor, felt.min()))


def _end(surface: Array, normals: Array, axis: Array) -> tuple[float, float, float]:
    """Return where points end along an axis, how gradually they do, and how far an edge may go on beyond."""
    along = surface @ axis
    last = np.argsort(along)[-2 * max(3, round(ENDS * len(along))) :]
    facing = float(np.clip(np.median(normals[last] @ axis), 0.0, 1.0))
    return float(np.median(along[last])), float(np.ptp(along[last])), EDGE * (1.0 - facing)


def _sorted(measured: list[_Length]) -> Dimensions:
    upright = max(measured, key=lambda m: abs(float(m.axis[2])))
    across = sorted((m for m in measured if m is not upright), key=lambda m: -m.value)
    ordered = [*across, upright]
    axes = [m.axis if m.axis[int(np.abs(m.axis).argmax())] > 0 else -m.axis for m in ordered]
    first, second, third = (m.how for m in ordered)
    return Dimensions(
        np.array([m.value for m in ordered]),
        np.array([m.sd for m in ordered]),
        np.array(axes),
        (first, second, third),
        np.array([m.short for m in ordered]),
    )
