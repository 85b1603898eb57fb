"""Hard points for the shape fits, each with what must come of it."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.perception import fit_cone, fit_cylinder, fit_plane, fit_shape, fit_sphere

FITS = {"plane": fit_plane, "sphere": fit_sphere, "cylinder": fit_cylinder, "cone": fit_cone, "shape": fit_shape}
SIDE = np.linspace(-5e-3, 5e-3, 24)
GRID = np.stack(np.meshgrid(SIDE, SIDE), axis=-1).reshape(-1, 2)
X, Y = GRID.T
LINE = np.arange(60) * 1e-3


def refused(pattern: str) -> Any:
    return IllConditioned, pattern


def near(read: Callable[[Any], float], value: float, tolerance: float) -> Callable[[Any], None]:
    """Return a check that what `read` takes from an answer is the value, to a relative tolerance."""

    def check(found: Any) -> None:
        assert abs(read(found) - value) <= tolerance * abs(value), f"{read(found)} is not {value}"

    return check


def at(height: Any) -> Any:
    return np.column_stack([GRID, np.broadcast_to(height, len(GRID))])


SURFACES = {
    "plane": at(0.1 * X - 0.2 * Y + 3e-3),
    "sphere": at(np.sqrt(0.015**2 - X**2 - Y**2)),
    "cylinder": at(np.sqrt(0.012**2 - (0.8 * X + 0.6 * Y) ** 2)),
    "cone": at(-0.4 * np.hypot(X - 1e-3, Y + 0.5e-3)),
}
TRUE = {
    "plane": (lambda f: f.normal[2], 1.0 / np.sqrt(1.05)),
    "sphere": (lambda f: f.radius, 0.015),
    "cylinder": (lambda f: f.radius, 0.012),
    "cone": (lambda f: f.angle, np.arctan(0.4)),
}
TURNED_OVER = {"sphere": lambda f: f.curvature, "cylinder": lambda f: f.curvature, "cone": lambda f: f.angle}
NO_ANSWER = {
    "empty": (np.empty((0, 3)), "there are 0"),
    "three points": (SURFACES["sphere"][[0, 5, 310]], "there are 3"),
    "all NaN": (np.full((50, 3), np.nan), "there are 0"),
    "one point many times": (np.tile(SURFACES["sphere"][:1], (50, 1)), "there are 1"),
    "one place, many heights": (np.column_stack([0 * LINE, 0 * LINE, LINE]), "one line of sight"),
    "collinear": (np.column_stack([LINE, 2 * LINE, 3 * LINE]), "one line"),
    "on a line as seen": (np.column_stack([LINE, 2 * LINE, LINE**2]), "one line"),
}


def broken(points: Any) -> Any:
    """Add copies of points that are NaN or infinite in one place."""
    wrong = points[:80].copy()
    wrong[:40, 2], wrong[40:, 0] = np.nan, np.inf
    return np.vstack([wrong, points])


def cases() -> list[tuple[str, Callable[[], Any], Any]]:
    """Return (name, call, what is expected of it)."""
    found: list[tuple[str, Callable[[], Any], Any]] = []
    for shape, fit in FITS.items():
        found += [(f"{shape}: {name}", partial(fit, p), refused(says)) for name, (p, says) in NO_ANSWER.items()]
    for shape, points in SURFACES.items():
        read, value = TRUE[shape]
        fit = FITS[shape]
        scaled = 1.0 if shape in ("plane", "cone") else 1e3
        found += [
            (f"{shape}: exact", partial(fit, points), near(read, value, 1e-6)),
            (f"{shape}: every point twice", partial(fit, np.vstack([points, points])), near(read, value, 1e-6)),
            (f"{shape}: NaN and infinite rows", partial(fit, broken(points)), near(read, value, 1e-6)),
            (f"{shape}: 1e6 mm away", partial(fit, points + [1e3, -1e3, 1e3]), near(read, value, 1e-3)),
            (f"{shape}: float32", partial(fit, points.astype(np.float32)), near(read, value, 1e-3)),
            (f"{shape}: in millimetres", partial(fit, points * 1e3), near(read, scaled * value, 1e-6)),
            (f"{shape}: chosen", partial(fit_shape, points), near(lambda s, r=read: r(s.fit), value, 1e-6)),
        ]
        if shape in TURNED_OVER:
            sign = partial(lambda r, f: np.sign(r(f)), TURNED_OVER[shape])
            found += [
                (f"{shape}: concave", partial(fit, points * [1, 1, -1]), near(sign, -1.0, 1e-9)),
                (f"{shape}: an exact plane", partial(fit, SURFACES["plane"]), refused("pl")),
            ]
    metres_as_millimetres = partial(fit_sphere, SURFACES["sphere"] * 1e3, noise=0.3e-3)
    found.append(("sphere: millimetres, noise in metres", metres_as_millimetres, near(lambda f: f.radius, 15.0, 1e-3)))
    too_loud = partial(fit_sphere, SURFACES["sphere"], noise=0.3)
    found.append(("sphere: metres, noise in millimetres", too_loud, refused("carries no radius")))
    return found


CASES = {name: (call, expected) for name, call, expected in cases()}
