"""Fusion of contacts and the dimensions of a cloud: too few points, all in one place, on a line, not numbers."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception import objects
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.hardcases.domains.perception.outlines import LABELS, scattered
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import Contact, cloud_of, fuse_contact, measure_object


def _contact(points: Any, **changes: Any) -> Contact:
    points = np.asarray(points, dtype=float)
    rays = np.tile([0.0, 0.0, -1.0], (len(points), 1))
    made = Contact(points, rays, LABELS, 1e-4, None, None, 0.0, np.zeros((80, 80, 3)), np.ones((80, 80)))
    return replace(made, **changes)


def _flat(count: int = 400, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> npt.NDArray[np.float64]:
    side = int(np.sqrt(count))
    x, y = np.meshgrid(np.arange(side) * 0.5e-3, np.arange(side) * 0.5e-3)
    return np.column_stack([x.ravel(), y.ravel(), np.full(side * side, 0.01)]) + at


def _top_height(points: Any) -> Any:
    return measure_object(cloud_of(points, 1e-4)).height


def _fused(points: Any, **changes: Any) -> Any:
    return fuse_contact(_contact(points, **changes))


def _again(higher: float, noise: float) -> Any:
    """Return the cloud of a plane that is seen a second time, so much higher, m, with another noise, m."""
    return fuse_contact(_contact(_flat(at=(0.0, 0.0, higher)), noise=noise), _fused(_flat()))


def _only_ends(found: Any) -> bool:
    off = np.abs(np.array([found.length - 0.06, found.width - 0.04]))
    return (
        found.how == ("faces", "extent", "extent")
        and bool((off < [0.05e-3, 1e-3]).all())
        and bool(abs(found.height - 0.02) < 3 * found.sd[2])
    )


def _far_block() -> Any:
    """Return by how much a block's lengths differ a kilometre away, m."""
    cloud = objects.block((0.03, 0.02, 0.03), 0.1e-3, np.random.default_rng(0))
    far = replace(cloud, points=cloud.points + [1e3, -1e3, 0.0])
    return measure_object(far).lengths - measure_object(cloud).lengths


def _block(flanks: tuple[int, ...]) -> Any:
    return measure_object(objects.block((0.04, 0.04, 0.04), 0.2e-3, np.random.default_rng(0), flanks=flanks))


def _by_faces(how: tuple[str, ...]) -> Any:
    def check(found: Any) -> bool:
        right = np.abs(found.lengths + found.short - 0.04).max() < 1.5e-3
        return sorted(found.how) == sorted(how) and bool(right)

    return check


def near(value: float, tolerance: float) -> Value:
    """Expect a number."""
    return Value(value, abs=tolerance, of=float)


ONE = Value(1)

CASES = (
    *group(
        "a contact may have no point, hardly any, or points that are no numbers",
        {
            "empty": (lambda: _fused(np.zeros((0, 3))), Refusal(NoContact, "no valid point")),
            "all invalid": (lambda: _fused(np.full((50, 3), np.nan)), Refusal(NoContact, "no valid point")),
            "three points": (lambda: _fused(_flat()[:3]), Refusal(IllConditioned, "too small")),
            "some NaN": (lambda: _fused(scattered(_flat(), slice(9), np.nan)).contacts, ONE),
            "some infinite": (lambda: _fused(scattered(_flat(), slice(9), np.inf)).contacts, ONE),
            "(n, 2)": (lambda: _fused(_flat()[:, :2]), Refusal(InvalidInput, "shape")),
        },
        prefix="fusion, ",
    ),
    *group(
        "points in one cell, on a line, far from the origin or of single precision",
        {
            "all points one": (lambda: len(_fused(np.ones((50, 3)))), ONE),
            "collinear": (lambda: _fused(np.outer(np.arange(50), [1e-3, 0, 0])).contacts, ONE),
            "float32": (lambda: _fused(_flat().astype(np.float32)).points[:, 2].mean(), near(0.01, 1e-8)),
            "at 1e6 mm": (lambda: _fused(_flat(at=(1e3, 1e3, 0))).points[:, 2].mean(), near(0.01, 1e-8)),
        },
        prefix="fusion, ",
    ),
    *group(
        "a mean is weighed by noise, which may not be known, or be nothing",
        {
            "noise not known": (lambda: _fused(_flat(), noise=np.nan), Refusal(InvalidInput, "noise")),
            "no noise": (lambda: _fused(_flat(), noise=0.0).sd.min(), near(1e-4, 1e-6)),
            "seen again": (
                lambda: _again(0.2e-3, 1e-4).points[:, 2].mean(),
                near(0.0101, 1e-8),
            ),
            "seen again more surely": (lambda: _again(0.1e-3, 1e-6).points[:, 2].mean(), near(0.0101, 3e-6)),
            "seen again elsewhere": (lambda: len(_again(2e-3, 1e-4)) // len(_again(0.0, 1e-4)), Value(2)),
            "cell of nothing": (lambda: fuse_contact(_contact(_flat()), cell=0.0), Refusal(InvalidInput, "positive")),
        },
        prefix="fusion, ",
    ),
    *group(
        "a cloud that spans no body has no dimensions",
        {
            "empty": (lambda: _top_height(np.zeros((0, 3))), Refusal(NoContact, "no point")),
            "all invalid": (lambda: _top_height(np.full((500, 3), np.nan)), Refusal(NoContact, "no point")),
            "three points": (lambda: _top_height(_flat()[:3]), Refusal(IllConditioned, "at least 100")),
            "all points one": (lambda: _top_height(np.ones((500, 3))), Refusal(IllConditioned, "line")),
            "collinear": (
                lambda: _top_height(np.outer(np.arange(500.0), [1.0, 2.0, 3.0])),
                Refusal(IllConditioned, "line"),
            ),
        },
        prefix="dimensions, ",
    ),
    *group(
        "a plane is no body either, but it has a height, also far away, with every point twice, or of single precision",
        {
            "exact plane": (lambda: _top_height(_flat()), near(0.01, 1e-9)),
            "exact plane at 1e6 mm": (lambda: _top_height(_flat(at=(1e3, -1e3, 0.0))), near(0.01, 1e-7)),
            "every point twice": (lambda: _top_height(np.repeat(_flat(), 2, axis=0)), near(0.01, 1e-9)),
            "float32": (lambda: _top_height(_flat().astype(np.float32)), near(0.01, 1e-7)),
        },
        prefix="dimensions, ",
    ),
    *group(
        "a bowed side has no face, a side may not be seen, and a block far away keeps its sizes",
        {
            "a round side": (
                lambda: measure_object(objects.half_cylinder(0.02, 0.06, 0.3e-3, np.random.default_rng(1))),
                Check("only its ends are faces, and its sizes right", _only_ends),
            ),
            "a block far away": (_far_block, Value(np.zeros(3), abs=1e-6)),
        },
        {
            f"a block with faces {flanks}": (
                partial(_block, flanks),
                Check("a size by the faces that are seen, else by the extent", _by_faces(how)),
            )
            for flanks, how in (((0, 1, 2), ("extent", "faces", "table")), ((), ("extent", "extent", "table")))
        },
        prefix="dimensions, ",
    ),
    *group(
        "an input that is no cloud",
        {
            "no noise": (lambda: cloud_of(_flat(), 0.0), Refusal(InvalidInput, "positive")),
            "millimetres as integers": (
                lambda: cloud_of((_flat() * 1e3).astype(int), 1.0),
                Refusal(InvalidInput, "floats"),
            ),
        },
        prefix="dimensions, ",
    ),
)
