"""Spheres of contacts that were cut out too small, too large, of faces, cones and dents, and of frames that show none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter

from stretch_bt.accuracy.perception import analytic
from stretch_bt.accuracy.perception.noise import WHITE_03, Noise, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, BodyPress, SheetView, seen
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception import (
    Contact,
    classify,
    deproject,
    fit_contact_sphere,
    fit_sphere,
    surface_noise,
    to_membrane,
    view_rays,
)
from stretch_bt.perception.shapes.contact_noise import noise_left
from stretch_bt.perception.types import CONTACT
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

RADIUS, PIXEL = 15e-3, 0.42e-3
BALL = BodyPress(Sphere(2 * RADIUS), 0.03, 0.018, (4e-3, -3e-3))
WHITE_05, BOTH = Noise(white=0.5e-3), Noise(white=0.2e-3, correlated=0.2e-3, kernel=2.5)


@cache
def _view(wanted: BodyPress = BALL) -> SheetView:
    return seen(wanted)


def _cut_out(wanted: BodyPress, seed: int, long: float = 1.0, wide: float = 1.0) -> Contact:
    return cut_out(_view(wanted), WHITE_03, seed, long, wide)


def cut_out(view: SheetView, noise: Noise, seed: int, long: float = 1.0, wide: float = 1.0) -> Contact:
    """Return an ellipse about the true contact, `long` times its size along i and `wide` times along j, as a contact."""
    points, valid = deproject(observe(view, noise, seed))
    points = to_membrane(points, PLANE_DISTANCE)
    true = points[view.touching & valid, :2]
    scale = 2.0 * true.std(axis=0) * [long, wide]
    with np.errstate(invalid="ignore"):
        mask = valid & (np.linalg.norm((points[..., :2] - true.mean(axis=0)) / scale, axis=-1) < 1.0)
    points[~valid] = np.nan
    labels = np.where(mask, 2, np.where(valid, 1, 255)).astype(np.uint8)
    rays, shown = view_rays(points[mask], (0.0, 0.0, PLANE_DISTANCE)), surface_noise(points)
    assert shown is not None
    sure = mask.astype(np.float32)
    return Contact(points[mask], rays, labels, shown.sd, 0.0, 0.03, 0.0, points, sure, noise_area=shown.area)


def _poor_start(long: float, wide: float) -> list[Any]:
    return [fit_contact_sphere(_cut_out(BALL, seed, long, wide)) for seed in range(3)]


def _found(fits: list[Any]) -> bool:
    touching = fit_sphere(_cut_out(BALL, 0).points)
    right = all(
        abs(fit.radius / RADIUS - 1) < 0.03
        and abs(fit.curvature - 1 / RADIUS) < 4 * fit.curvature_sd
        and np.abs(fit.center[:2] - [4e-3, -3e-3]).max() < 0.5e-3
        for fit in fits
    )
    return right and bool(np.mean([fit.curvature_sd for fit in fits]) < 2.5 * touching.curvature_sd)


def _hardly_seen() -> Any:
    """Return the sphere of a contact around which nothing has depth."""
    contact = _cut_out(BALL, 0)
    surface = contact.surface.copy()
    surface[:] = np.nan
    return fit_contact_sphere(replace(contact, surface=surface))


def _alone() -> Any:
    wide = _cut_out(BALL, 0, 1.6, 2.0)
    return fit_sphere(wide.points, rays=wide.rays, noise=wide.noise)


def _dent() -> Any:
    contact, over = _cut_out(BALL, 0), [1.0, 1.0, -1.0]
    return fit_contact_sphere(replace(contact, points=contact.points * over, surface=contact.surface * over))


def _height_over(kind: str, size: float, degrees: float, r: Any) -> tuple[Any, float]:
    """Return how high a sheet of constant tension stands over a body of revolution, by the distance from its axis, m.

    A sphere or a cone that it leaves at an angle; a disc, from whose edge it falls at that angle.
    """
    angle = np.radians(degrees)
    rim = size * np.sin(angle) if kind == "sphere" else size
    neck = rim * np.sin(angle)
    inside = {
        "sphere": np.sqrt(np.maximum(size**2 - r**2, 0.0)) - size * np.cos(angle),
        "face": np.zeros_like(r),
        "cone": (rim - r) * np.tan(angle),
    }[kind]
    outside = -neck * (np.arccosh(np.maximum(r, rim) / neck) - np.arccosh(rim / neck))
    return np.where(r < rim, inside, outside), rim


def _contact_over(kind: str, size: float, degrees: float, noise: Noise, seed: int) -> Contact:
    """Return the view from straight above of a sheet over a body, its middle off the middle and leaning."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[0:200, 0:200]
    x, y = (u - 100) * PIXEL, (v - 100) * PIXEL
    away = np.hypot(x - 3e-3, y + 2e-3)
    height, rim = _height_over(kind, size, degrees, away)
    error = noise.white * rng.standard_normal(x.shape)
    if noise.correlated:
        blurred = gaussian_filter(rng.standard_normal(x.shape), noise.kernel)
        error += noise.correlated * 2.0 * np.sqrt(np.pi) * noise.kernel * blurred
    surface = np.stack([x, y, height + 0.01 * x + error], axis=-1).astype(np.float32)
    touching = away < 0.8 * rim
    points, shown = surface[touching], surface_noise(surface)
    assert shown is not None
    rays = np.broadcast_to(np.array([0.0, 0.0, -1.0], np.float32), points.shape)
    labels, sure = np.where(touching, 2, 1).astype(np.uint8), touching.astype(np.float32)
    return Contact(points, rays, labels, shown.sd, 0.0, None, 0.0, surface, sure, noise_area=shown.area)


def _reasons(kind: str, size: float, degrees: float, noise: Noise) -> list[str]:
    """Return the reasons for which two contacts have no radius; the radius of one that has."""
    found = []
    for seed in range(2):
        try:
            found.append(f"{fit_contact_sphere(_contact_over(kind, size, degrees, noise, seed)).radius} m")
        except IllConditioned as error:
            found.append(error.reason)
    return found


def _caps(radius: float, degrees: float, noise: Noise) -> list[tuple[float, float]]:
    """Return by how many deviations each curvature is off, and the deviation over the curvature."""
    fits = [fit_contact_sphere(_contact_over("sphere", radius, degrees, noise, seed)) for seed in range(2)]
    return [(abs(fit.curvature - 1 / radius) / fit.curvature_sd, fit.curvature_sd * radius) for fit in fits]


def _whole(depth: Any) -> Any:
    """Return the sphere of the contact in a depth image, m, from the labels on."""
    points, valid = deproject(depth, analytic.camera(*depth.shape))
    if not valid.any():
        raise NoContact("the frame has no valid pixel")
    points = to_membrane(points, analytic.PLANE_DISTANCE)
    found = classify(points, valid)
    touching = points[found.labels == CONTACT]
    if not len(touching):
        raise NoContact("no part of the membrane is in contact")
    rays = view_rays(touching, (0.0, 0.0, analytic.PLANE_DISTANCE))
    return fit_contact_sphere(
        Contact(touching, rays, found.labels, found.noise, None, None, 0.0, points, found.confidence)
    )


def _blank(*size: int) -> Any:
    return np.zeros(size or (60, 80), dtype=np.float32)


def _one_pixel() -> Any:
    depth = _blank()
    depth[30, 40] = 0.2
    return depth


def _half_gone() -> Any:
    still = analytic.render(analytic.sphere_press(30e-3, np.radians(25)), analytic.camera())
    depth = analytic.noisy(still, 0.3e-3, np.random.default_rng(0))
    depth[:, :180] = 0.0
    return _whole(depth)


NO_MEMBRANE = Refusal(NoContact, "no part of the membrane")
NO_PIXEL = Refusal(NoContact, "no valid pixel")
FLAT_FACE = BodyPress(Cylinder(0.02), 0.03, 0.008, (0.004, -0.006))
CAPS = ((14e-3, 30), (25e-3, 20), (10e-3, 40), (8e-3, 55), (35e-3, 25))
NO_RADIUS = (
    ("face", 6e-3, 25, "no radius"),
    ("face", 12e-3, 15, "no radius"),
    ("cone", 8e-3, 35, "cone"),
    ("cone", 12e-3, 25, "cone"),
)
NOISES = {"white, 0.3 mm": WHITE_03, "white, 0.5 mm": WHITE_05, "white and correlated": BOTH}


def _all_say(reason: str) -> Check:
    return Check(f"each is refused: {reason}", lambda found: all(reason in told for told in found))


def _smooth_part(seed: int) -> tuple[tuple[float, float], ...]:
    return noise_left(np.random.default_rng(seed).normal(0.0, 1e-4, (60, 60)), 1e-12).smooth


CASES: tuple[Hard, ...] = (
    *group(
        "a segmented contact is too long, too wide, or only a part",
        {
            f"cut out {long:g} times as long, {wide:g} times as wide": (
                partial(_poor_start, long, wide),
                Check("radius within 3 %, centre within 0.5 mm, as sure as of the true contact", _found),
            )
            for long, wide in ((1.0, 1.0), (1.3, 1.0), (2.0, 2.0), (0.6, 0.8), (0.5, 1.0))
        },
        {
            "hardly any pixel seen": (_hardly_seen, Refusal(IllConditioned, "hardly any pixel has depth")),
        },
        {"cut out too large, by itself": (_alone, Refusal(IllConditioned, "by the same amount"))},
        prefix="contact, ",
    ),
    *group(
        "a face, a cone and a dent look round where noise is large",
        {
            f"a {kind} of {1e3 * size:g} mm, {name}": (partial(_reasons, kind, size, degrees, noise), _all_say(reason))
            for kind, size, degrees, reason in NO_RADIUS
            for name, noise in NOISES.items()
        },
        {
            "a dent": (_dent, Refusal(IllConditioned, "concave")),
            "a flat face": (lambda: fit_contact_sphere(_cut_out(FLAT_FACE, 0, 0.8, 0.8)), Refusal(IllConditioned)),
        },
        {
            f"a cap of {1e3 * radius:g} mm, {name}": (
                partial(_caps, radius, degrees, noise),
                Check(
                    "within 4 of its deviations, which is below 15 %", lambda f: all(a < 4 and b < 0.15 for a, b in f)
                ),
            )
            for radius, degrees in CAPS
            for name, noise in NOISES.items()
        },
        prefix="contact, ",
        costly=tuple(
            [
                f"a {kind} of {1e3 * size:g} mm, {name}"
                for kind, size, *_ in NO_RADIUS
                for name in ("white, 0.3 mm", "white, 0.5 mm")
            ]
            + [
                f"a cap of {1e3 * r:g} mm, {name}"
                for r, _ in CAPS
                for name in ("white, 0.5 mm", "white and correlated")
            ]
        ),
    ),
    *group(
        "noise that pixels do not share must not look as if they did",
        {f"draw {seed}": (partial(_smooth_part, seed), Value(())) for seed in range(6)},
        prefix="white noise, ",
    ),
    *group(
        "an image that shows no contact has no sphere either",
        {
            "empty": (lambda: _whole(_blank(0, 0)), NO_PIXEL),
            "all invalid": (lambda: _whole(_blank()), NO_PIXEL),
            "all NaN": (lambda: _whole(_blank() * np.float32(np.nan)), NO_PIXEL),
            "one valid pixel": (lambda: _whole(_one_pixel()), NO_MEMBRANE),
            "constant depth": (lambda: _whole(_blank() + np.float32(0.2)), NO_MEMBRANE),
            "exact tilted plane": (
                lambda: _whole(0.2 / (1 + 0.1 * np.linspace(-0.3, 0.3, 333)) + np.zeros((213, 1))),
                NO_MEMBRANE,
            ),
            "millimetres": (lambda: _whole(_blank() + np.float32(200)), Refusal(InvalidInput, "another unit")),
            "half dropped out": (
                _half_gone,
                Refusal(IllConditioned, "its two curvatures differ"),
            ),
        },
        prefix="image, ",
    ),
)
