"""Perception: each step against what the sheet solver says is there, beside its CPU time."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules

from stretch_bt.accuracy.points import Kind, Point

__all__ = ["ABOUT", "KINDS", "points"]

ABOUT = """\
Presses of the finite-strain sheet, seen by a camera 200 mm above it at 0.42 mm a pixel: 213 x 333 pixels, counts of
0.125 mm, 1 % of the pixels without a value. Errors are root mean squares over 40 frames of a press (4 with --quick), times
medians of the calls. Where there is a Cramer-Rao bound, the least error of any unbiased estimator, it is the reference;
refusals are left out of the error and counted in the case. The prior behind a contact's size has seen other presses of
the same sheet. correlated 1 mm is smoothed by 3 pixels, 0.6 alike from frame to
frame, and the mean of 8 frames."""

KINDS = {
    "normal": Kind("deg", 57.29578),
    "curvature": Kind("1/m", 1.0),
    "overlap": Kind("%", 100.0),
    "height": Kind("um", 1e6),
    "radius": Kind("%", 100.0),
    "diameter": Kind("mm", 1e3),
    "circularity": Kind("1", 1.0),
}


def points(quick: bool) -> Iterator[Point]:
    """Yield every point, step by step; with `quick` those of few presses and frames."""
    from stretch_bt.accuracy.perception import steps

    for module in iter_modules(steps.__path__, f"{steps.__name__}."):
        yield from import_module(module.name).points(quick)
