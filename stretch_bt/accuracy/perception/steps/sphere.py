"""Sphere fits: 1/R over the number of points, on the true contact and on our own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from stretch_bt.accuracy.perception.analytic import curvature_bound
from stretch_bt.accuracy.perception.measure import FULL, NOISES, QUICK, SPHERES, frames_of, run, words
from stretch_bt.accuracy.perception.noise import observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, Seen, seen
from stretch_bt.accuracy.points import REFERENCE, Point
from stretch_bt.frames import DepthFrame
from stretch_bt.perception import (
    Sphere,
    deproject,
    find_contact,
    fit_contact_sphere,
    fit_sphere,
    to_membrane,
    view_rays,
)
from stretch_bt.simulation.membrane.indenters.sphere import Sphere as Body

__all__ = ["points"]

_SHARES = (8, 4, 2, 1)


def points(quick: bool) -> Iterator[Point]:
    """Yield the root mean square error of 1/R, over 1/R, beside its Cramer-Rao bound."""
    for press in SPHERES[: 1 if quick else None]:
        view = seen(press)
        body = press.indenter
        assert isinstance(body, Body)
        radius = body.diameter / 2
        for name, noise in list(NOISES.items())[: 1 if quick else 3]:
            case = f"{words(press)}, {name}"
            yield Point(case, "sphere fit: Cramer-Rao bound", "radius", _bound(view, noise.white), None, REFERENCE)
            for share in _SHARES:
                answers = run(
                    partial(_fit, view, share),
                    lambda s: s.curvature * radius - 1.0,  # noqa: B023
                    frames_of(view, noise, quick),
                )
                yield answers.point(case, f"sphere fit, true contact: every {share}. point", "radius")
            seen_frames = ((observe(view, noise, seed),) for seed in range(QUICK if quick else FULL))
            answers = run(_found, lambda s: s.curvature * radius - 1.0, seen_frames)  # noqa: B023
            yield answers.point(case, "sphere end to end: frame, contact, cap and skirt", "radius")


def _found(frame: DepthFrame) -> Sphere:
    return fit_contact_sphere(find_contact(frame))


def _fit(view: Seen, share: int, points_: Any, valid: Any) -> Sphere:
    cap = points_[view.touching & valid][::share]
    return fit_sphere(cap, rays=view_rays(cap, (0.0, 0.0, PLANE_DISTANCE)))


def _bound(view: Seen, noise: float) -> float:
    """Return the Cramer-Rao bound of 1/R, over 1/R, for white noise, m, on all pixels that touch."""
    body, (x, y) = view.press.indenter, view.press.at
    assert isinstance(body, Body)
    radius = body.diameter / 2
    points_ = to_membrane(deproject(view.depth, CAMERA)[0], PLANE_DISTANCE)[view.touching].astype(float)
    return curvature_bound(points_ - [x, y, view.press.depth - radius], radius, noise) * radius
