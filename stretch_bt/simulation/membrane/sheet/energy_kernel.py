"""Strain energy of an incompressible sheet in plane stress, with first and second derivatives, compiled.

Everything is a function of t = tr C and J = det C of the (2, 2) right Cauchy-Green tensor of the mid-surface.
Incompressibility gives I1 = t + 1/J and I2 = J + t/J, so W = c1 (I1 - 3) + c2 (I2 - 3) per unit of shear modulus.
"""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["strain_energy"]


@kernel()
def mooney_rivlin(t: Any, j: Any, c1: Any, c2: Any) -> Any:
    """Return W and its derivatives by t, j, tt, tj, jj."""
    r = 1.0 / j
    return (
        c1 * (t + r - 3.0) + c2 * (j + t * r - 3.0),
        c1 + c2 * r,
        -c1 * r * r + c2 * (1.0 - t * r * r),
        0.0,
        -c2 * r * r,
        2.0 * (c1 + c2 * t) * r * r * r,
    )


@kernel()
def relaxed(t: Any, j: Any, c1: Any, c2: Any) -> Any:
    """Return the same for the tension field (Pipkin 1986): no compression, wrinkles cost nothing."""
    s = math.sqrt(max(0.25 * t * t - j, 0.0))
    e = 0.5 * t + s  # the larger principal stretch squared
    if e <= 1.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if j * j >= e:  # the width is at least the one that simple tension leaves
        return mooney_rivlin(t, j, c1, c2)
    root = math.sqrt(e)
    w = c1 * (e + 2.0 / root - 3.0) + c2 * (2.0 * root + 1.0 / e - 3.0)
    first = c1 * (1.0 - 1.0 / (e * root)) + c2 * (1.0 / root - 1.0 / (e * e))
    second = 1.5 * c1 / (e * e * root) + c2 * (2.0 / (e * e * e) - 0.5 / (e * root))
    et, ej = 0.5 + 0.25 * t / s, -0.5 / s
    cube = 1.0 / (s * s * s)
    return (
        w,
        first * et,
        first * ej,
        second * et * et - 0.25 * j * cube * first,
        second * et * ej + 0.125 * t * cube * first,
        second * ej * ej - 0.25 * cube * first,
    )


@kernel()
def soften(w: Any, peak: Any, r: Any, m: Any, beta: Any) -> Any:
    """Return the softened energy and its first and second derivative by w (Ogden and Roxburgh 1999).

    `peak` is the largest energy that the point has seen; the derivative is eta = 1 - erf((peak - w)/(m + beta peak))/r.
    """
    if w >= peak:
        return w, 1.0, 0.0
    b = m + beta * peak
    u = (peak - w) / b
    bell = math.exp(-u * u) / math.sqrt(math.pi)
    gone = math.erf(u)
    return w + b / r * (u * gone + bell - 1.0 / math.sqrt(math.pi)), 1.0 - gone / r, 2.0 * bell / (r * b)


@kernel()
def strain_energy(t: Any, j: Any, peak: Any, law: Any) -> Any:
    """Return W and its derivatives by t, j, tt, tj, jj at a point that has seen the energy `peak`.

    `law` (6,) holds c1, c2, the stiffness left to wrinkles (1 switches the tension field off), and Mullins r, m, beta
    (r = 0 switches it off).
    """
    w, wt, wj, wtt, wtj, wjj = mooney_rivlin(t, j, law[0], law[1])
    if law[2] < 1.0:
        keep, ease = law[2], 1.0 - law[2]
        v, vt, vj, vtt, vtj, vjj = relaxed(t, j, law[0], law[1])
        w, wt, wj = keep * w + ease * v, keep * wt + ease * vt, keep * wj + ease * vj
        wtt, wtj, wjj = keep * wtt + ease * vtt, keep * wtj + ease * vtj, keep * wjj + ease * vjj
    if law[3] > 0.0:
        w, eta, rate = soften(w, peak, law[3], law[4], law[5])
        wtt, wtj, wjj = eta * wtt + rate * wt * wt, eta * wtj + rate * wt * wj, eta * wjj + rate * wj * wj
        wt, wj = eta * wt, eta * wj
    return w, wt, wj, wtt, wtj, wjj
