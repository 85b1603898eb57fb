"""Sphere fits: 1/R over the number of points, on the true contact and on our own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.peers import guarded, pyransac3d_sphere
from stretch_bt.accuracy.perception.analytic import curvature_bound
from stretch_bt.accuracy.perception.measure import NOISES, SPHERES, bound_job, clouds, frames, job, view_of, words
from stretch_bt.accuracy.perception.noise import Noise
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, BodyPress
from stretch_bt.accuracy.points import Setting
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

__all__ = ["jobs"]

_SHARES = {8: "every eighth point", 4: "every fourth point", 2: "every other point", 1: "all points"}


def jobs(count: int) -> Iterator[Job]:
    """Yield the root mean square error of 1/R, over 1/R, beside its Cramer-Rao bound."""
    for press, name in product(SPHERES, [name for name, noise in NOISES.items() if noise.white]):
        yield from _of_case(press, name, NOISES[name], count)


def _of_case(press: BodyPress, name: str, noise: Noise, count: int) -> Iterator[Job]:
    case, radius = f"{words(press)}, {name}", _radius(press)
    yield bound_job(case, count, "radius", partial(_bound, press, noise.white))

    def error(found: Sphere) -> float:
        return found.curvature * radius - 1.0

    whole = Setting("sphere", "frame, contact, cap and skirt")
    seen_frames = partial(frames, press, noise, count)
    yield job(case, whole, "radius", count, _found, error, seen_frames, seconds=0.15, default=True)
    inputs = partial(clouds, press, noise, count)
    for share, words_ in _SHARES.items():
        setting, solve = Setting("sphere fit, true contact", words_), partial(_fit, press, share)
        yield job(case, setting, "radius", count, solve, error, inputs)
    peer = Setting(pyransac3d_sphere.NAME, pyransac3d_sphere.SETTING)
    ransac = partial(_ransac, press, noise.white)
    tried = job(case, peer, "radius", count, ransac, lambda c: c * radius - 1.0, inputs, seconds=0.3)
    yield guarded("pyransac3d_sphere", tried)


def _radius(press: BodyPress) -> float:
    body = press.indenter
    assert isinstance(body, Body)
    return body.diameter / 2


def _found(frame: DepthFrame) -> Sphere:
    return fit_contact_sphere(find_contact(frame))


def _cap(press: BodyPress, points_: Any, valid: Any) -> Any:
    return points_[view_of(press).touching & valid]


def _fit(press: BodyPress, share: int, points_: Any, valid: Any) -> Sphere:
    cap = _cap(press, points_, valid)[::share]
    return fit_sphere(cap, rays=view_rays(cap, (0.0, 0.0, PLANE_DISTANCE)))


def _ransac(press: BodyPress, noise: float, points_: Any, valid: Any) -> float:
    return pyransac3d_sphere.curvature(_cap(press, points_, valid), noise)


def _bound(press: BodyPress, noise: float) -> float:
    """Return the Cramer-Rao bound of 1/R, over 1/R, for white noise, m, on all pixels that touch."""
    view, (x, y), radius = view_of(press), press.at, _radius(press)
    points_ = to_membrane(deproject(view.depth, CAMERA)[0], PLANE_DISTANCE)[view.touching].astype(float)
    return curvature_bound(points_ - [x, y, press.depth - radius], radius, noise) * radius
