"""Sphere fits: 1/R over the number of points, on the true contact and on our own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.accuracy.perception.measure import FULL, NOISES, QUICK, SPHERES, frames_of, run, words
from stretch_bt.accuracy.perception.noise import Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, Seen, seen
from stretch_bt.accuracy.points import REFERENCE, Point
from stretch_bt.errors import NoContact
from stretch_bt.perception import Contact, Sphere, find_contact, fit_contact_sphere, fit_sphere, view_rays
from stretch_bt.simulation.membrane.indenters.sphere import Sphere as Body

__all__ = ["curvature_bound", "points"]

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
            touching, _ = next(frames_of(view, noise, True))
            bound = curvature_bound(touching[view.touching], radius, noise.white) * radius
            yield Point(case, "sphere fit: Cramer-Rao bound", "radius", bound, None, REFERENCE)
            for share in _SHARES:
                answers = run(
                    partial(_fit, view, share),
                    lambda s: s.curvature * radius - 1.0,  # noqa: B023
                    frames_of(view, noise, quick),
                )
                yield answers.point(case, f"sphere fit, true contact: every {share}. point", "radius")
            answers = run(fit_contact_sphere, lambda s: s.curvature * radius - 1.0, _contacts(view, noise, quick))  # noqa: B023
            yield answers.point(case, "sphere end to end: cap and skirt", "radius")


def _contacts(view: Seen, noise: Noise, quick: bool) -> Iterator[tuple[Contact]]:
    for seed in range(QUICK if quick else FULL):
        with suppress(NoContact):
            yield (find_contact(observe(view, noise, seed)),)


def _fit(view: Seen, share: int, points_: Any, valid: Any) -> Sphere:
    cap = points_[view.touching & valid][::share]
    return fit_sphere(cap, rays=view_rays(cap, (0.0, 0.0, PLANE_DISTANCE)))


def curvature_bound(cap: Any, radius: float, noise: float) -> float:
    """Return the Cramer-Rao bound of 1/R, 1/m, for white noise, m, along z on points (n, 3), m, of a spherical cap."""
    finite = np.isfinite(cap).all(axis=1)
    x, y = (cap[finite, :2] - cap[finite, :2].mean(axis=0)).T
    z = np.sqrt(np.maximum(radius**2 - x * x - y * y, (0.1 * radius) ** 2))
    jacobian = np.column_stack([x / z, y / z, np.ones_like(x), radius / z])
    covariance = np.linalg.inv(jacobian.T @ jacobian) * noise**2
    return float(np.sqrt(covariance[3, 3])) / radius**2
