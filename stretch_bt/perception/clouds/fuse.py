"""Contacts from many poses of the hand, fused into one cloud."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import Pose
from stretch_bt.perception.cells import cells_of
from stretch_bt.perception.clouds.cloud import CELL, FLOOR, Array, Cloud, Frame
from stretch_bt.perception.deprojection import to_world, world_turn
from stretch_bt.perception.types import CLOUD, MADE, Contact

__all__ = ["fuse_contact", "placed"]

NEIGHBOURS = 12
STRAY = 6.0  # standard deviations from the points around it beyond which a point of one frame is dropped
SAME = 4.0  # standard deviations within which a new point is the surface that is there already
OUTVOTED = 3  # times as often seen as another surface in its column, which is then dropped
LEAST_NOISE = 1e-6  # m


def fuse_contact(contact: Contact, cloud: Cloud | None = None, *, cell: float = CELL, floor: float = FLOOR) -> Cloud:
    """Return a cloud with the points of one more contact in it.

    Space is divided into columns along the axis nearest to the view. In each column the contact gives one height, at the
    middle of the column; heights of several contacts are averaged, weighted by 1 / sd^2. Depth noise is alike in
    neighbouring pixels, so points of one frame in a column count as one, with the standard deviation of one. Points that
    stand out of their own frame are dropped; a surface found elsewhere in a column begins a layer of its own, and goes
    when the other is seen three times as often.

    Parameters
    ----------
    contact : Contact
        In the world when it knows the pose of the hand; otherwise in the frame of a hand that points down.
    cloud : Cloud
        What was fused before; None begins a new one.
    cell : float, m
        Width of a column.
    floor : float, m
        Standard deviation that all points share.

    Raises
    ------
    NoContact
        The contact has no valid point.
    IllConditioned
        It has too few points to find those that stand out.
    InvalidInput
        Cloud and contact are in different frames, the cloud has another cell or floor, or these are not positive.
    """
    check_kind("contact", contact, Contact, MADE)
    if cloud is not None:
        check_kind("cloud", cloud, Cloud, CLOUD)
    check_numbers("in m", cell=cell, floor=floor)
    points, rays, noise, frame = placed(contact)
    if cloud is None:
        if not (cell > 0 and floor >= 0):
            raise InvalidInput(f"cell and floor are lengths in metres, the cell positive, got {cell} and {floor}")
        nothing = np.zeros((0, 3))
        none = np.zeros((0, 3), dtype=np.int64)
        cloud = Cloud(nothing, np.zeros(0), nothing, np.zeros(0, dtype=np.int64), none, frame, cell, floor)
    if cloud.frame != frame:
        raise InvalidInput(f"the cloud is in the frame of the {cloud.frame}, the contact in the frame of the {frame}")
    if (cloud.cell, cloud.floor) != (cell, floor):
        raise InvalidInput(
            f"the cloud has a cell of {cloud.cell} m and a floor of {cloud.floor} m, got {cell}, {floor}"
        )
    return _merged(cloud, _sighting(points, rays, noise, cloud))


def placed(contact: Contact) -> tuple[Array, Array, Array, Frame]:
    """Return points (n, 3), m, rays (n, 3) and noise along them (n,), m, in the world or the hand's frame, and which."""
    points, rays = np.asarray(contact.points, np.float64), np.asarray(contact.rays, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or rays.shape != points.shape:
        raise InvalidInput(f"points and rays of a contact have shape (n, 3), got {points.shape} and {rays.shape}")
    if not (np.isfinite(contact.noise) and contact.noise >= 0):
        raise InvalidInput(f"the noise of a contact is a standard deviation in metres, got {contact.noise}")
    kept = np.isfinite(points).all(axis=1) & np.isfinite(rays).all(axis=1)
    points, rays = points[kept], rays[kept]
    if not len(points):
        raise NoContact("there is no valid point in contact: nothing can be added; press deeper")
    if len(points) <= NEIGHBOURS:
        raise IllConditioned(
            f"a contact of {len(points)} points is too small to fuse; it takes {NEIGHBOURS + 1}; press deeper"
        )
    pose = contact.pose or Pose((0.0, 0.0, contact.hand_height or 0.0))
    along = max(contact.noise, LEAST_NOISE) / np.maximum(np.abs(rays[:, 2]), 0.1)
    frame: Frame = "hand" if contact.pose is None else "world"
    return to_world(points, pose), rays @ world_turn(pose).T, along, frame


def _sighting(points: Array, rays: Array, noise: Array, cloud: Cloud) -> Cloud:
    """Return what one contact says of each column: a cloud of its own."""
    axis = int(np.abs(rays.mean(axis=0)).argmax())
    across = [k for k in range(3) if k != axis]
    slope, kept = _slopes(points[:, across], points[:, axis], float(noise.mean()))
    points, rays, noise = points[kept], rays[kept], noise[kept]
    cells = np.floor(points[:, across] / cloud.cell).astype(np.int64)
    middle = (cells + 0.5) * cloud.cell
    # The heights of a column are those at its middle, so that contacts which saw other spots of it agree.
    height = points[:, axis] + ((middle - points[:, across]) * slope).sum(axis=1)
    found = cells_of(cells)
    first = found.first
    at = np.empty((len(first), 3))
    at[:, across], at[:, axis] = middle[first], found.means(height)
    seen_from = np.column_stack([found.means(ray) for ray in rays.T])
    seen_from /= np.linalg.norm(seen_from, axis=1, keepdims=True)
    columns = np.column_stack([np.full(len(first), axis), found.cells])
    once = np.ones(len(first), dtype=np.int64)
    return Cloud(at, found.means(noise), seen_from, once, columns, cloud.frame, cloud.cell, cloud.floor, 1)


def _slopes(places: Array, heights: Array, noise: float) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return which points of a frame agree with those around them, and the slopes (m, 2) of the surface at these."""
    from scipy.spatial import cKDTree

    _, near = cKDTree(places).query(places, k=NEIGHBOURS + 1)
    around = heights[near]
    middle = np.median(around, axis=1)
    spread = 1.4826 * np.median(np.abs(around - middle[:, None]), axis=1)
    kept = np.abs(heights - middle) <= STRAY * np.maximum(spread, noise)
    fits = kept[near].astype(np.float64)
    total = np.maximum(fits.sum(axis=1, keepdims=True), 1.0)
    x, y, z = (v - (v * fits).sum(axis=1, keepdims=True) / total for v in (*np.moveaxis(places[near], 2, 0), around))
    xx, xy, yy = (fits * x * x).sum(axis=1), (fits * x * y).sum(axis=1), (fits * y * y).sum(axis=1)
    xz, yz = (fits * x * z).sum(axis=1), (fits * y * z).sum(axis=1)
    least = np.maximum(xx * yy - xy * xy, 1e-6 * (xx + yy) ** 2 + 1e-300)
    return np.column_stack([yy * xz - xy * yz, xx * yz - xy * xz])[kept] / least[kept, None], kept


def _merged(cloud: Cloud, new: Cloud) -> Cloud:
    """Return the cloud with a sighting in it."""
    old_index, new_index, pull, reach = _pairs(cloud, new)
    points, noise, rays, seen = cloud.points.copy(), cloud.noise.copy(), cloud.rays.copy(), cloud.seen.copy()
    before, now = 1 / noise[old_index] ** 2, 1 / new.noise[new_index] ** 2
    share = (now / (before + now))[:, None]
    points[old_index] += share * (new.points[new_index] - points[old_index])
    rays[old_index] += share * (new.rays[new_index] - rays[old_index])
    rays[old_index] /= np.linalg.norm(rays[old_index], axis=1, keepdims=True)
    noise[old_index] = 1 / np.sqrt(before + now)
    seen[old_index] += 1
    fresh = np.ones(len(new), dtype=bool)
    fresh[new_index] = False
    joined = replace(
        cloud,
        points=np.concatenate([points, new.points[fresh]]),
        noise=np.concatenate([noise, new.noise[fresh]]),
        rays=np.concatenate([rays, new.rays[fresh]]),
        seen=np.concatenate([seen, new.seen[fresh]]),
        columns=np.concatenate([cloud.columns, new.columns[fresh]]),
        contacts=cloud.contacts + 1,
        scatter=cloud.scatter + float(((pull / reach) ** 2).sum()),
        repeats=cloud.repeats + len(pull),
        apart=None,
    )
    return _without_outvoted(joined)


def _pairs(cloud: Cloud, new: Cloud) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Array, Array]:
    """Return which points are one surface, old and new, how far apart they are along the column, and the sd of that."""
    keys, fresh = _keys(cloud.columns, new.columns)
    order = np.argsort(keys, kind="stable")
    first, last = (np.searchsorted(keys[order], fresh, side) for side in ("left", "right"))
    new_index = np.repeat(np.arange(len(new)), last - first)
    step = np.arange(len(new_index)) - np.repeat(np.cumsum(last - first) - (last - first), last - first)
    old_index = order[np.repeat(first, last - first) + step]
    axis = new.columns[new_index, 0]
    pull = new.points[new_index, axis] - cloud.points[old_index, axis]
    reach = np.hypot(cloud.noise[old_index], new.noise[new_index])
    best = np.lexsort([np.abs(pull) / reach, new_index])  # of several layers the one that fits best
    best = best[np.concatenate([[True], np.diff(new_index[best]) > 0])] if len(best) else best
    best = best[np.abs(pull[best]) <= SAME * np.hypot(reach[best], cloud.floor)]
    return old_index[best], new_index[best], pull[best], reach[best]


def _keys(*columns: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
    """Return the columns of several clouds as numbers, equal where the columns are."""
    numbers = cells_of(np.concatenate(columns)).which
    return np.split(numbers, np.cumsum([len(c) for c in columns])[:-1])


def _without_outvoted(cloud: Cloud) -> Cloud:
    """Leave out points where another surface of the same column was seen far more often."""
    (keys,) = _keys(cloud.columns)
    most = np.zeros(int(keys.max()) + 1, dtype=np.int64)
    np.maximum.at(most, keys, cloud.seen)
    kept = (OUTVOTED * cloud.seen > most[keys]) | (most[keys] == 0)
    if kept.all():
        return cloud
    return cloud.part(kept)
