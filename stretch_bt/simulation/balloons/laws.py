"""Force laws of a balloon's fill, by the drop of its top."""

from __future__ import annotations

import math

from stretch_bt.simulation.objects.response import Law

__all__ = ["hertz", "linear", "no_force", "scaled", "together"]


def hertz(modulus: float, radius: float) -> Law:
    """Return the law of an elastic ball of effective modulus, Pa, and radius, m: 4/3 E sqrt(R) d^1.5 (Hertz 1881)."""
    factor = 4 / 3 * modulus * math.sqrt(radius)

    def law(drop: float) -> tuple[float, float]:
        root = math.sqrt(max(drop, 0.0))
        return factor * root * max(drop, 0.0), 1.5 * factor * root

    return law


def linear(stiffness: float) -> Law:
    """Return the law of a spring, N/m, that only pushes."""
    return lambda drop: (stiffness * drop, stiffness) if drop > 0 else (0.0, 0.0)


def no_force(drop: float) -> tuple[float, float]:
    """Return nothing: the law of a slack bag."""
    return 0.0, 0.0


def scaled(law: Law, force: float, length: float) -> Law:
    """Return a law without units, N over `force` and m over `length`, in N and m."""
    per = force / length

    def real(drop: float) -> tuple[float, float]:
        value, slope = law(drop / length)
        return force * value, per * slope

    return real


def together(one: Law, other: Law) -> Law:
    """Return the law of two bodies that are pressed by the same drop."""

    def law(drop: float) -> tuple[float, float]:
        (f, a), (g, b) = one(drop), other(drop)
        return f + g, a + b

    return law
