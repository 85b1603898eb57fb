"""Where a depth camera stands in the hand, from one look at the free membrane between the fingers."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.cells import cells_of
from stretch_bt.perception.deprojection import deproject
from stretch_bt.perception.types import MaskArray
from stretch_bt.units import Estimate

__all__ = ["HandView", "OutOfView", "view_of_hand"]

Array = npt.NDArray[np.float64]

#: how far the membrane may be off its given distance at first, and off its plane then, m
_SEARCHED, _NEAR = 0.035, 0.006
#: the middle part of the membrane that edges are looked for at: the corners of a sheet are drawn in
_MIDDLE = 0.5
#: share of the pixels along an edge that must lie on one line
_ON_LINE = 0.5
#: columns or rows that must show both edges
_LEAST = 24
#: how often the tilt is looked at again, because edges and sag are found in the plane
_PASSES = 3
#: squares in which heights are averaged, m, and the part of the way to the fingers in which they are
_CELL, _INSIDE = 0.007, 0.95
#: lengths, m, over which the camera's error may be alike, and the own variance of each square over the variance of this error
_ALIKE, _OWN = (0.01, 0.02, 0.04, 0.08, 0.16, 0.32), (1e-4, 1e-2, 0.3, 10.0)
#: a pixel's edge is somewhere in it, alike for all that it runs along: the standard deviation of a number from 0 to 1
_UNIFORM = 1 / math.sqrt(12)
#: largest residual of a free membrane to its shape, and how much nearer to the camera its middle is than its ends at most, m, whatever the
#: camera's error: free ones showed 1.7 and 1.0 mm at most, and pressed by 5 mm or more one of the two is larger
_BUMP, _RISEN = 0.0019, 0.0016


class OutOfView(IllConditioned):
    """The membrane is seen, and an end or a side of it is not, as far as can be told."""


@dataclass(frozen=True, slots=True)
class HandView:
    """The camera in the membrane frame, m and rad, and the length of the membrane between the fingers, m.

    `distance` is its z. It is turned about x by `tilt_x`, then about y by `tilt_y`, then about z by `yaw`, by the usual
    matrices; in the membrane frame, which is left-handed, that is clockwise seen from the end of the axis. Without any it looks straight down, its
    rows along x. Where its optical axis meets the membrane's plane,
    (`aim_x`, `aim_y`), is known better than its place: a smooth error of the camera does alike to place and tilt.
    """

    x: Estimate
    y: Estimate
    distance: Estimate
    tilt_x: Estimate
    tilt_y: Estimate
    yaw: Estimate
    length: Estimate
    aim_x: Estimate
    aim_y: Estimate


def view_of_hand(frame: DepthFrame, distance: float) -> HandView:
    """Return where the camera of a frame stands over a membrane that touches nothing.

    The plane through the membrane's ends gives its distance and its tilts, with a sag between the ends that is fitted beside them; the
    ends under the fingers and the free sides, which are alike on both sides of the middle, give the rest. A scale error of the camera's
    depth is not seen: it is in `distance`.

    Parameters
    ----------
    frame
        One frame, or better a mean of some.
    distance
        Distance from the camera to the membrane, m, known to 35 mm.

    Raises
    ------
    OutOfView
        One of the membrane's edges is not in view, or something is before it.
    IllConditioned
        The membrane is not in view, or it touches something.
    """
    if not distance > 0:
        raise InvalidInput(f"the distance to the membrane must be above 0 m, got {distance:g}")
    points, valid = deproject(frame)
    seen: Array = np.asarray(points, dtype=np.float64)
    normal, on = _plane(seen, valid & (np.abs(seen[..., 2] - distance) < _SEARCHED))
    wide, high = distance / frame.intrinsics.fx, distance / frame.intrinsics.fy
    for again in reversed(range(_PASSES + 1)):
        flat = seen @ _upright(normal).T
        ends = _edges(flat, on, along=1, pitch=high)
        sides = _edges(flat, on, along=0, pitch=wide)
        yaw = -math.atan(ends.slope)
        middle, length = _middle(ends, sides), (ends.high - ends.low) * math.cos(yaw)
        level, cover = _level(flat, on, (ends.low + ends.high) / 2, length / 2)
        if not again:  # the result keeps the plane in which the edges were found
            break
        normal = np.array([-level[1], -level[2], 1.0]) @ _upright(normal)
        normal /= np.linalg.norm(normal)
    tilt_x, tilt_y = math.atan2(normal[1], -normal[2]), math.asin(-normal[0])
    tilt_sd = math.sqrt(cover[2, 2]), math.sqrt(cover[1, 1])
    place = -_about_z(yaw) @ middle
    centre = np.array([*middle, level[0]]) @ _upright(normal)
    aim = -_about_z(yaw) @ centre[:2]
    return HandView(
        x=Estimate(place[0], math.hypot(sides.sd, level[0] * tilt_sd[1], middle[1] * ends.slope_sd)),
        y=Estimate(place[1], math.hypot(ends.sd, level[0] * tilt_sd[0], middle[0] * ends.slope_sd)),
        distance=Estimate(-level[0], math.sqrt(cover[0, 0])),
        tilt_x=Estimate(tilt_x, tilt_sd[0]),
        tilt_y=Estimate(tilt_y, tilt_sd[1]),
        yaw=Estimate(yaw, ends.slope_sd),
        length=Estimate(length, math.sqrt(2) * ends.sd * math.cos(yaw)),
        aim_x=Estimate(aim[0], math.hypot(sides.sd, middle[1] * ends.slope_sd)),
        aim_y=Estimate(aim[1], math.hypot(ends.sd, middle[0] * ends.slope_sd)),
    )


@dataclass(frozen=True, slots=True)
class _Edges:
    """Two edges across a direction, where they are in the middle, m, their slope, and standard deviations."""

    low: float
    high: float
    sd: float
    slope: float
    slope_sd: float


def _middle(ends: _Edges, sides: _Edges) -> Array:
    """Return where the line between both ends crosses the line between both sides (2,), m: the sides are across the ends."""
    x, y = (sides.low + sides.high) / 2, (ends.low + ends.high) / 2
    across = (x - ends.slope * y) / (1 + ends.slope**2)
    return np.array([across, y + ends.slope * across])


def _plane(points: Array, mask: MaskArray) -> tuple[Array, MaskArray]:
    """Return the unit normal towards the camera of the plane that most points are on, and which are."""
    on, normal = mask, np.array([0.0, 0.0, -1.0])
    for _ in range(6):
        chosen = points[on]
        if len(chosen) < _LEAST**2:
            raise IllConditioned(
                "the membrane is not in view; look whether the hand is free, and at `plane_distance` of the cell"
            )
        centre = np.median(chosen, axis=0)
        fitted, *_ = np.linalg.lstsq(
            np.column_stack([chosen[:, :2] - centre[:2], np.ones(len(chosen))]), chosen[:, 2], rcond=None
        )
        normal = np.array([fitted[0], fitted[1], -1.0])
        normal /= np.linalg.norm(normal)
        offset = float(normal @ [centre[0], centre[1], fitted[2]])
        on = mask & (np.abs(points @ normal - offset) < _NEAR)
    return normal, on


def _upright(normal: Array) -> Array:
    """Return the turn (3, 3) from the camera's axes into the membrane's but for its yaw."""
    tilt_x, tilt_y = math.atan2(normal[1], -normal[2]), math.asin(-normal[0])
    about_x = np.array([[1, 0, 0], [0, math.cos(tilt_x), -math.sin(tilt_x)], [0, math.sin(tilt_x), math.cos(tilt_x)]])
    about_y = np.array([[math.cos(tilt_y), 0, math.sin(tilt_y)], [0, 1, 0], [-math.sin(tilt_y), 0, math.cos(tilt_y)]])
    turned: Array = about_y @ about_x @ np.diag([1.0, 1.0, -1.0])
    return turned


def _about_z(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def _edges(flat: Array, on: MaskArray, *, along: int, pitch: float) -> _Edges:
    """Return where the membrane begins and ends along y (1, the fingers) or x (0, its free sides), at lines across its middle."""
    where, mask = (flat, on) if along == 1 else (flat.transpose(1, 0, 2), on.T)
    across = 1 - along
    covered = mask.sum(axis=0) > 0.5 * max(int(mask.sum(axis=0).max()), 1)
    lines = np.flatnonzero(covered)
    if len(lines) < _LEAST:
        raise IllConditioned("the membrane is not in view; look whether the hand is free, and where the camera points")
    spare = round(len(lines) * (1 - _MIDDLE) / 2)
    lines = lines[spare : len(lines) - spare]
    first, last = mask[:, lines].argmax(axis=0), mask.shape[0] - 1 - mask[::-1, lines].argmax(axis=0)
    if np.median(first) < 1 or np.median(last) > mask.shape[0] - 2:
        which = "an end of the membrane under the fingers" if along == 1 else "a free side of the membrane"
        raise OutOfView(
            f"{which} is out of view, so that its length is not known; move the camera so that it sees all of it"
        )
    found = []
    for at, sign in ((first, -1), (last, 1)):
        place = where[at, lines]
        found.append(_line(place[:, across], place[:, along] + sign * 0.5 * pitch))
    (low, slope_low, left), (high, slope_high, right) = found
    span = float(np.ptp(where[first, lines][:, across]))
    scatter = math.hypot(left, right) / 2 / math.sqrt(len(lines) / 4)
    half = _UNIFORM * pitch
    sd = math.hypot(half, scatter)  # shifts that both edges share are in it
    slope_sd = math.hypot(2 * half, scatter) / span
    return _Edges(low, high, sd, (slope_low + slope_high) / 2, slope_sd)


def _line(x: Array, y: Array) -> tuple[float, float, float]:
    """Return height at x = 0, slope and scatter of a line through most of some points: single pixels without a value are passed over."""
    keep = np.abs(y - np.median(y)) < 0.005
    for _ in range(3):
        if np.count_nonzero(keep) < _ON_LINE * len(keep):
            raise OutOfView(
                "an edge of the membrane is no line: it is out of view, or something is before it; free the view of all of it"
            )
        slope, height = np.polyfit(x[keep], y[keep], 1)
        rest = y - height - slope * x
        scatter = 1.4826 * float(np.median(np.abs(rest[keep])))
        keep = np.abs(rest) <= max(3 * scatter, 5e-4)
    return float(height), float(slope), float(np.std(rest[keep]))


def _level(flat: Array, on: MaskArray, middle: float, half: float) -> tuple[Array, Array]:
    """Return height at the middle and slopes along x and y of the plane through the ends, and their covariance.

    A sag between the ends is fitted beside them. The residual is taken for the camera's error, which is alike over some length; that length
    and its size have the greatest restricted likelihood (Patterson and Thompson, Biometrika 58, 1971), so that the covariance
    includes the error of a slope from an error that is smooth over the membrane.
    """
    x, y, z = _cells(flat, on, middle, half)
    part, across = (y - middle) / half, x / max(float(np.abs(x).max()), 1e-6)
    bow = 1 - part**2
    design = np.column_stack([np.ones_like(x), x, y, bow, bow * across**2, bow * part**2])
    # the nearest shape: the residual to the likeliest one holds a smooth error of the camera too, which may be larger
    near_by = np.linalg.lstsq(design, z, rcond=None)[0]
    most, risen = float(np.abs(z - design @ near_by).max()), float(near_by[3])
    if most > _BUMP or risen > _RISEN:
        raise IllConditioned(
            f"the membrane stands off by {1e3 * max(most, risen):.1f} mm: it touches something, or is wrinkled; free it"
        )
    free = len(x) - design.shape[1]
    if free < 1:
        raise IllConditioned(
            "too few squares of the membrane are seen to find how the camera stands; free the view of all of it"
        )
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    best: tuple[float, Array, Array] | None = None
    for length, share in itertools.product(_ALIKE, _OWN):
        near = math.sqrt(3) * apart / length
        alike = (1 + near) * np.exp(-near) + share * np.eye(len(x))
        root = np.linalg.cholesky(alike)
        white, shown = np.linalg.solve(root, design), np.linalg.solve(root, z)
        normal = white.T @ white
        fitted = np.linalg.solve(normal, white.T @ shown)
        variance = max(float(np.sum((shown - white @ fitted) ** 2)) / free, 1e-18)
        likely = -free * math.log(variance) - 2 * float(np.log(np.diag(root)).sum()) - np.linalg.slogdet(normal)[1]
        if best is None or likely > best[0]:
            best = float(likely), fitted, variance * np.linalg.inv(normal)
    assert best is not None
    return best[1][:3], best[2][:3, :3]


def _cells(flat: Array, on: MaskArray, middle: float, half: float) -> tuple[Array, Array, Array]:
    """Return means of x, y and z in the squares of a grid over the membrane, its rims left out."""
    points = flat[on]
    points = points[np.abs(points[:, 1] - middle) < _INSIDE * half]
    cells = cells_of(np.round(points[:, :2] / _CELL).astype(np.int64))
    full = cells.counts > 0.5 * cells.counts.max()
    x, y, z = (cells.means(along)[full] for along in points.T)
    return x, y, z
