"""Fits of planes, spheres, cylinders and cones to points: too few, on a line, not numbers, far away, of another shape."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception import fit_cone, fit_cylinder, fit_plane, fit_shape, fit_sphere

Read = Callable[[Any], Any]

FITS: dict[str, Callable[..., Any]] = {
    "plane": fit_plane,
    "sphere": fit_sphere,
    "cylinder": fit_cylinder,
    "cone": fit_cone,
    "shape": fit_shape,
}
SIDE = np.linspace(-5e-3, 5e-3, 24)
GRID = np.stack(np.meshgrid(SIDE, SIDE), axis=-1).reshape(-1, 2)
X, Y = GRID.T
LINE = np.arange(60) * 1e-3


def _at(height: Any) -> Any:
    return np.column_stack([GRID, np.broadcast_to(height, len(GRID))])


SURFACES = {
    "plane": _at(0.1 * X - 0.2 * Y + 3e-3),
    "sphere": _at(np.sqrt(0.015**2 - X**2 - Y**2)),
    "cylinder": _at(np.sqrt(0.012**2 - (0.8 * X + 0.6 * Y) ** 2)),
    "cone": _at(-0.4 * np.hypot(X - 1e-3, Y + 0.5e-3)),
}
TRUE: dict[str, tuple[Read, float]] = {
    "plane": (lambda f: f.normal[2], 1.0 / np.sqrt(1.05)),
    "sphere": (lambda f: f.radius, 0.015),
    "cylinder": (lambda f: f.radius, 0.012),
    "cone": (lambda f: f.angle, float(np.arctan(0.4))),
}
SIGNED: dict[str, Read] = {
    "sphere": lambda f: np.sign(f.curvature),
    "cylinder": lambda f: np.sign(f.curvature),
    "cone": lambda f: np.sign(f.angle),
}
NO_ANSWER = {
    "empty": (np.empty((0, 3)), "there are 0"),
    "three points": (SURFACES["sphere"][[0, 5, 310]], "there are 3"),
    "all NaN": (np.full((50, 3), np.nan), "there are 0"),
    "one point many times": (np.tile(SURFACES["sphere"][:1], (50, 1)), "there are 1"),
    "one place, many heights": (np.column_stack([0 * LINE, 0 * LINE, LINE]), "one line of sight"),
    "collinear": (np.column_stack([LINE, 2 * LINE, 3 * LINE]), "one line"),
    "on a line as seen": (np.column_stack([LINE, 2 * LINE, LINE**2]), "one line"),
}


def _broken(points: Any) -> Any:
    """Return points with copies that are NaN or infinite in one place."""
    wrong = points[:80].copy()
    wrong[:40, 2], wrong[40:, 0] = np.nan, np.inf
    return np.vstack([wrong, points])


def _of_too_few() -> Iterator[Hard]:
    for shape, fit in FITS.items():
        rows = {
            name: (partial(fit, points), Refusal(IllConditioned, said)) for name, (points, said) in NO_ANSWER.items()
        }
        yield from group("so few different points do not determine a shape", rows, prefix=f"{shape}, ")


def _of_shapes() -> Iterator[Hard]:
    for shape, points in SURFACES.items():
        fit, (read, value) = FITS[shape], TRUE[shape]
        scaled = 1.0 if shape in ("plane", "cone") else 1e3
        yield from group(
            "the shape is the same from points that are exact, doubled, far away, of single precision or in another unit",
            {
                "exact": (partial(fit, points), Value(value, rel=1e-6, of=read)),
                "every point twice": (partial(fit, np.vstack([points, points])), Value(value, rel=1e-6, of=read)),
                "NaN and infinite rows": (partial(fit, _broken(points)), Value(value, rel=1e-6, of=read)),
                "1e6 mm away": (partial(fit, points + [1e3, -1e3, 1e3]), Value(value, rel=1e-3, of=read)),
                "float32": (partial(fit, points.astype(np.float32)), Value(value, rel=1e-3, of=read)),
                "in millimetres": (partial(fit, points * 1e3), Value(scaled * value, rel=1e-6, of=read)),
                "chosen": (partial(fit_shape, points), Value(value, rel=1e-6, of=_of_its_fit(read))),
            },
            prefix=f"{shape}, ",
        )


def _of_its_fit(read: Read) -> Read:
    return lambda chosen: read(chosen.fit)


def _turned_over() -> Iterator[Hard]:
    for shape, sign in SIGNED.items():
        yield from group(
            "a hollow is no bump, and a plane has no curvature",
            {
                "concave": (partial(FITS[shape], SURFACES[shape] * [1, 1, -1]), Value(-1.0, of=sign)),
                "an exact plane": (partial(FITS[shape], SURFACES["plane"]), Refusal(IllConditioned, "pl")),
            },
            prefix=f"{shape}, ",
        )


def _mixed_units() -> Iterator[Hard]:
    ball = SURFACES["sphere"]
    yield from group(
        "points and noise in different units",
        {
            "millimetres, noise in metres": (
                partial(fit_sphere, ball * 1e3, noise=0.3e-3),
                Value(15.0, rel=1e-3, of=lambda f: f.radius),
            ),
            "metres, noise in millimetres": (
                partial(fit_sphere, ball, noise=0.3),
                Refusal(IllConditioned, "carries no radius"),
            ),
        },
        prefix="sphere, ",
    )


CASES = (*_of_too_few(), *_of_shapes(), *_turned_over(), *_mixed_units())
