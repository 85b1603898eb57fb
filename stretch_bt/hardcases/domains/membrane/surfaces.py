"""The form of a solved sheet: known forces, a surface on the indenter and at its edges, and nothing beside it."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from stretch_bt.hardcases.expect import Check, Range, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation import press

#: depth, m, and the force of an independent solver over shear modulus and 1 mm^2, which is right within 1 %
KNOWN = {0.005: 5.74, 0.010: 15.19, 0.015: 27.42}


def _solved(**options: Any) -> Any:
    arguments: dict[str, Any] = {"indenter": "sphere:20mm", "stretch": 0.03, "depth": 0.01, **options}
    return press(**arguments).detail


def _known(depth: float) -> float:
    return press("sphere:20mm", 0.03, depth, shear_modulus=1e3).force * 1e3


def _off_the_sphere() -> float:
    """Return how far the surface is off the sphere where it touches, m."""
    region = _solved().region()
    return float(np.abs(np.linalg.norm(region.points, axis=1) - 0.01).max())


def _edges() -> list[float]:
    """Return the ends of the surface along and across at its clamps, m, and its height there."""
    edges = _solved().shape.points(5, 7)
    along = edges[0, :, 1].max(), edges[-1, :, 1].min()
    across = edges[0, 0, 0], edges[0, -1, 0]
    return [float(v) for v in (*along, *across, np.abs(edges[[0, -1], :, 2]).max())]


def _heights() -> Any:
    """Return heights over the tip, near a clamp and beside the sheet, m."""
    return _solved().shape.height(np.array([0.0, 0.0, 0.2]), np.array([0.0, 0.064, 0.0]))


def _ends_right(heights: Any) -> bool:
    return bool(abs(heights[0] - 0.010) < 0.05e-3 and heights[1] < 0.5e-3 and np.isnan(heights[2]))


def _work(shape: str, stretch: float, depth: float, options: dict[str, Any]) -> list[float]:
    """Return the force over the derivative of the energy, and the largest sum of force and reaction over it."""
    step = 5e-5
    start = press(shape, stretch, depth, **options)  # the slack corners of an unstretched sheet rest in many ways
    below, found, above = (
        _solved(indenter=shape, stretch=stretch, depth=depth + k * step, start=start, **options) for k in (-1, 0, 1)
    )
    balance = np.abs(found.force + found.reaction).max() / found.force[2]
    return [float(found.force[2] / ((above.energy - below.energy) / (2 * step))), float(balance)]


#: indenter, stretch and depth, m, and further options
WORKED: dict[str, tuple[str, float, float, dict[str, Any]]] = {
    "a sphere": ("sphere:20mm", 0.03, 0.010, {}),
    "a large sphere, far stretched": ("sphere:30mm", 0.06, 0.015, {}),
    "a sphere aside": ("sphere:20mm", 0.03, 0.010, {"at": (0.010, 0.030)}),
    "a slack sheet": ("sphere:20mm", 0.0, 0.005, {}),
    "a cone": ("cone:45deg", 0.01, 0.012, {}),
    "a leaning cube": ("cube:20mm", 0.03, 0.010, {"tilt": (0.1, 0.0)}),
}

CASES: tuple[Hard, ...] = (
    *group(
        "a balanced and settled force may still be the force of another problem",
        {
            f"{1e3 * depth:g} mm, by another solver": (partial(_known, depth), Value(f, rel=0.01))
            for depth, f in KNOWN.items()
        },
        {
            f"force and energy, {name}": (
                partial(_work, *given),
                Check("the same within 0.05 %, and balanced", lambda w: abs(w[0] - 1) < 5e-4 and w[1] < 1e-6),
            )
            for name, given in WORKED.items()
        },
    ),
    *group(
        "a surface is interpolated between control points, up to its edges and not beyond",
        {
            "on the sphere where it touches": (_off_the_sphere, Range(0.0, 0.08e-3)),
            "at its clamps": (_edges, Value([-0.065, 0.065, -0.045, 0.045, 0.0], abs=1e-12)),
            "over the tip, at a clamp and beside the sheet": (
                _heights,
                Check("10 mm, hardly any, and not a number", _ends_right),
            ),
        },
    ),
    *group(
        "slack corners creep for tens of iterations, and change no force",
        {
            "iterations at stretch 0": (
                partial(press, "sphere:20mm", 0.0, 0.005),
                Range(1, 100, of=lambda found: found.iterations),
            ),
            "iterations of a usual press": (
                partial(press, "sphere:20mm", 0.03, 0.010),
                Range(1, 30, of=lambda found: found.iterations),
            ),
        },
    ),
)
