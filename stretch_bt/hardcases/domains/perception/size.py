"""The measurement of size: contacts that are cut off, double, not there, or in another unit."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates

from stretch_bt.accuracy.perception.noise import Noise, observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, BodyPress, seen
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.hardcases.expect import Check, Refusal
from stretch_bt.hardcases.hard import group
from stretch_bt.perception import deproject, diameters, measure_contact, to_membrane
from stretch_bt.perception.size.cells import cells_of
from stretch_bt.perception.size.choose import choose
from stretch_bt.perception.size.hypothesis import Context
from stretch_bt.perception.size.misfit import misfit_of
from stretch_bt.perception.size.prior import shipped_prior
from stretch_bt.perception.size.start import start_of
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

STRETCH, WIDTH, DEPTH = 0.03, 0.02, 0.008
NOISE = Noise(white=0.3e-3)
Change = Callable[[Any], Any]


@cache
def _press(at: tuple[float, float] = (0.0, 0.0)) -> tuple[Any, Any]:
    """Return points in the membrane frame and labels that know the truth."""
    view = seen(BodyPress(Cylinder(WIDTH), STRETCH, DEPTH, at))
    points, valid = deproject(observe(view, NOISE, 1))
    points = to_membrane(points, PLANE_DISTANCE)
    face = view.touching | (points[..., 2] > DEPTH - 0.1e-3)
    return points, np.where(valid, np.where(face, 2, np.where(points[..., 2] > 1e-3, 1, 0)), 255).astype(np.uint8)


def _measured(
    at: tuple[float, float] = (0.0, 0.0), move: Change | None = None, relabel: Change | None = None, **options: Any
) -> Any:
    points, labels = (a.copy() for a in _press(at))
    points, labels = move(points) if move else points, relabel(labels) if relabel else labels
    return measure_contact(points, labels, **{"stretch": STRETCH, "hypothesis": "circle", **options})


def _about(within: float = 0.4e-3) -> Check:
    """Expect the width, and that its stated error covers it."""

    def check(found: Any) -> bool:
        off = abs(found.diameter_i - WIDTH)
        covered = off < min(within, 4.0 * found.diameter_i_sd)
        return bool(covered and found.diameter_i == found.diameter_j and found.diameter_i_sd < 2.0 * within)

    return Check(f"20 mm wide within {within * 1e3:g} mm and four of its deviations", check)


def _without_columns(first: int, last: int) -> Change:
    def relabel(labels: Any) -> Any:
        labels[:, first:last] = 255
        return labels

    return relabel


def _flying(points: Any) -> Any:
    rng = np.random.default_rng(5)
    hit = rng.random(points.shape[:2]) < 0.01
    points[..., 2][hit] += rng.uniform(-0.02, 0.02, int(hit.sum()))
    return points


def _broken(points: Any) -> Any:
    points[::7, ::5] = np.nan
    points[3::7, 2::5, 2] = np.inf
    return points


def _level(points: Any) -> Any:
    points[..., 2] = 0.0
    return points


def _one_pixel(labels: Any) -> Any:
    labels[labels != 255] = 255
    labels[166, 106] = 2
    return labels


def _undo_contact(labels: Any) -> Any:
    labels[labels == 2] = 1
    return labels


def _two_presses() -> Any:
    """Return the size of two cylinders side by side, as the higher of two surfaces."""
    (left, labels), (right, others) = _press((-0.018, 0.0)), _press((0.018, 0.0))
    higher = right[..., 2] > left[..., 2]
    points = np.where(higher[..., None], right, left)
    points[..., :2] = deproject(np.full((CAMERA.height, CAMERA.width), PLANE_DISTANCE - DEPTH), CAMERA)[0][..., :2]
    return measure_contact(points, np.where(higher, others, labels), stretch=STRETCH)


def _star(count: int, share: float) -> list[float]:
    """Return in how many places an outline stands out from its circle, and how far, mm.

    It is the outline of the press, drawn out by a share in `count` places and in between them.
    """
    points, labels = _press()
    x, y = points[..., 0], points[..., 1]
    drawn = 1 + share * np.cos(count * np.arctan2(y, x))
    v, u = np.indices(labels.shape)
    known = np.isfinite(x)
    across, down = np.polyfit(x[known], u[known], 1), np.polyfit(y[known], v[known], 1)
    from_v, from_u = np.polyval(down, y / drawn), np.polyval(across, x / drawn)
    at = np.nan_to_num([from_v, from_u], nan=-1.0)
    points = points.copy()
    points[..., 2] = map_coordinates(np.nan_to_num(points[..., 2]), at, order=1)
    cells = cells_of(points, map_coordinates(labels, at, order=0, cval=255))
    found = choose(["circle"], cells, start_of(cells), Context(STRETCH, 0.3e-3, 0.0, shipped_prior()), noise=0.0)
    misfit = misfit_of(found.shape, found.fit, cells)
    return [misfit.harmonic, 1e3 * misfit.off]


def _stands_out(count: int) -> Check:
    return Check(
        f"found in {count} places, by 0.25 to 0.75 mm", lambda found: found[0] == count and 0.25 < found[1] < 0.75
    )


def _camera_frame(points: Any) -> Any:
    points[..., 2] = PLANE_DISTANCE - points[..., 2]
    return points


CUT = Refusal(IllConditioned, "too little of the")

CASES = (
    *group(
        "no contact, or hardly any",
        {
            "as it is": (_measured, _about()),
            "empty frame": (
                lambda: diameters(np.zeros((0, 0, 3)), np.zeros((0, 0), np.uint8)),
                Refusal(NoContact, "no valid pixel"),
            ),
            "all invalid": (
                lambda: _measured(relabel=lambda s: np.full_like(s, 255)),
                Refusal(NoContact, "no valid pixel"),
            ),
            "nothing in contact": (
                lambda: _measured(relabel=_undo_contact),
                Refusal(NoContact, "labelled as in contact"),
            ),
            "one valid pixel": (lambda: _measured(relabel=_one_pixel), Refusal(NoContact, "hardly any")),
            "constant depth": (lambda: _measured(move=_level), Refusal(NoContact, "do not rise")),
            "concave": (lambda: _measured(move=lambda p: p * [1.0, 1.0, -1.0]), Refusal(NoContact, "do not rise")),
            "two contacts": (_two_presses, Refusal(IllConditioned, "two separate contacts")),
        },
        prefix="size, ",
    ),
    *group(
        "a part of the face is cut off, near a clamp or at the free edge",
        {
            "beside the rim cut off": (lambda: _measured(relabel=_without_columns(0, 76)), _about()),
            "a sixth of the face cut off": (lambda: _measured(relabel=_without_columns(0, 90)), _about(1e-3)),
            "half of the face cut off": (lambda: _measured(relabel=_without_columns(0, 106)), CUT),
            "half of the frame gone": (lambda: _measured(relabel=_without_columns(110, 213)), CUT),
            "near the clamp": (lambda: _measured((0.0, 0.025)), _about(0.8e-3)),
            "at the free edge": (lambda: _measured((0.034, 0.0)), CUT),
        },
        prefix="size, ",
    ),
    *group(
        "the outline may belong to no known shape",
        {
            f"{count} corners": (
                partial(_star, count, 0.06),
                _stands_out(count),
            )
            for count in (3, 5, 6)
        },
        {"no corners": (partial(_star, 6, 0.0), Check("off by 0.15 mm at most", lambda found: found[1] < 0.15))},
        prefix="size, ",
    ),
    *group(
        "points that are no numbers, fly, have single precision, or are given elsewhere",
        {
            "NaN and infinite": (lambda: _measured(move=_broken), _about()),
            "flying pixels": (lambda: _measured(move=_flying), _about()),
            "single precision": (lambda: _measured(move=lambda p: p.astype(np.float32)), _about()),
            "a kilometre away": (lambda: _measured(move=lambda p: p + [1e3, -1e3, 0.0]), _about()),
            "in the camera frame": (lambda: _measured(move=_camera_frame), _about()),
            "stretch not known": (lambda: _measured(stretch=None), _about(0.6e-3)),
        },
        prefix="size, ",
    ),
    *group(
        "an input has another unit, type, shape or name",
        {
            "metres passed as millimetres": (
                lambda: _measured(move=lambda p: p * 1e3),
                Refusal(InvalidInput, "metres"),
            ),
            "stretch in millimetres": (lambda: _measured(stretch=30.0), Refusal(InvalidInput, "stretch")),
            "fillet below 0": (lambda: _measured(fillet=-1e-3), Refusal(InvalidInput, "fillet")),
            "no such shape": (lambda: _measured(hypothesis="star"), Refusal(InvalidInput, "'auto' or one of")),
            "labels of another type": (
                lambda: _measured(relabel=lambda s: s.astype(int)),
                Refusal(InvalidInput, "uint8"),
            ),
            "points of another shape": (
                lambda: diameters(np.zeros((4, 3)), np.zeros((4, 4), np.uint8)),
                Refusal(InvalidInput, "h, w, 3"),
            ),
        },
        prefix="size, ",
    ),
)
