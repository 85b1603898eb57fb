"""The shape of a membrane pressed by something round: its contact, and the free skirt around it.

A free membrane under even tension has zero mean curvature; around an axis that is a catenoid, r = c cosh((z - z0) / c),
whose slope at the contact edge matches a sphere of radius R when its neck c is a^2 / R.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.quantity_text import format_quantity
from stretch_bt.simulation.objects.base import HertzForm
from stretch_bt.simulation.solve import find_root
from stretch_bt.units import KINDS

__all__ = ["Surface", "pressed_surface"]


@dataclass(frozen=True, slots=True)
class Surface:
    """Height over the flat membrane as a function of the distance from an axis; all in m.

    `depth` at the axis, contact up to `edge`, a skirt with this `neck` down to 0 at `span`; the contact is a cap of
    `cap_radius`, or flat where that is infinite.
    """

    depth: float
    edge: float
    neck: float
    span: float
    cap_radius: float

    def height(self, distance: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the height, m, at distances from the axis, m."""
        r = np.asarray(distance, dtype=float)
        inside = np.minimum(r, self.edge)
        if math.isfinite(self.cap_radius):
            z = self.depth - inside**2 / (self.cap_radius + np.sqrt(self.cap_radius**2 - inside**2))
        else:
            z = np.full(r.shape, self.depth)
        if self.neck > 0:
            outer = np.clip(r, self.edge, self.span)
            z = z - self.neck * (np.arccosh(outer / self.neck) - math.acosh(self.edge / self.neck))
        return np.where(r >= self.span, 0.0, z)


def pressed_surface(form: HertzForm, depth: float, span: float) -> Surface:
    """Return the membrane, held flat at radius `span`, m, with a body sunk into it by `depth`, m.

    A sphere meets it with a cap up to the contact radius a, then comes a catenoid with neck a^2 / R; a cylinder with its flat
    end, then a catenoid from its rim; a plane all over.

    Raises
    ------
    NoEquilibrium
        The membrane would have to wrap around the body.
    """
    return _SURFACES[form.kind](form.radius, depth, span)


def _on_sphere(radius: float, depth: float, span: float) -> Surface:
    def total(a: float) -> float:
        cap = a * a / (radius + math.sqrt(max(radius**2 - a * a, 0.0)))  # without cancellation
        return cap + _skirt_drop(a, a * a / radius, span)

    edge = _solve_edge(total, depth, radius, span)
    return Surface(depth, edge, edge * edge / radius, span, radius)


def _on_cylinder(radius: float, depth: float, span: float) -> Surface:
    neck = _solve_edge(lambda c: _skirt_drop(radius, c, span), depth, radius, span)
    return Surface(depth, radius, neck, span, math.inf)


def _on_plane(radius: float, depth: float, span: float) -> Surface:
    return Surface(depth, math.inf, 0.0, math.inf, math.inf)


_SURFACES = {"sphere": _on_sphere, "cylinder": _on_cylinder, "plane": _on_plane}


def _skirt_drop(edge: float, neck: float, span: float) -> float:
    """Return how far a catenoid falls from radius `edge` to radius `span`, m."""
    if neck <= 0:
        return 0.0
    return neck * (math.acosh(max(span / neck, 1.0)) - math.acosh(max(edge / neck, 1.0)))


def _solve_edge(total: Callable[[float], float], depth: float, radius: float, span: float) -> float:
    """Return the contact radius, or neck, at which the surface is `depth` high; `total` gives height against it.

    Raises
    ------
    NoEquilibrium
        The membrane would have to wrap around the object: its height has a limit point before this depth.
    """
    if depth == 0:
        return 0.0
    limit, highest = _limit_point(total, min(radius, span))
    if depth > highest:
        deepest = format_quantity(highest, KINDS["Length"])
        raise NoEquilibrium(f"the membrane wraps around the object past a depth of {deepest} (limit point)")

    def residual(x: float) -> tuple[float, float]:
        step = 1e-5 * x  # small against x itself, which for a light touch is far below the limit
        low, high = x - step, min(x + step, limit)
        return depth - total(x), (total(low) - total(high)) / (high - low)

    return find_root(residual, 0.0, limit, limit / 2, "shape of the membrane").x


def _limit_point(total: Callable[[float], float], most: float) -> tuple[float, float]:
    """Return where the height is largest, by golden section, and that height."""
    ratio = (math.sqrt(5) - 1) / 2
    low, high = 0.0, most
    for _ in range(60):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (left, high) if total(left) < total(right) else (low, right)
    best = max((high, most), key=total)
    return best, total(best)
