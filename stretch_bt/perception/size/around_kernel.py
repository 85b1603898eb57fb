"""The skirt around a mapped outline, place by place, compiled; around.py and exterior.py say what it is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["fill_skirt"]

FLATTEST = 0.05  # share of C below which f', 0 at a corner, counts as this share
FARTHEST = 4.0  # tau, beyond which the skirt is level
STEEPEST = 2e3  # 1/m, of tau, to which the rounding of the rim follows it
TURNS = 20
MET = 1e-12  # of the squared last step
HARMONIC = 4  # highest order of the harmonic functions
VARYING = 2  # highest order of those with tau^2


@kernel()
def inverse(z: Any) -> Any:
    """Return 1 / z."""
    square = max(z.real * z.real + z.imag * z.imag, 1e-300)
    return complex(z.real / square, -z.imag / square)


@kernel()
def kept_outside(z: Any, least: Any) -> Any:
    """Return z, or the place with its direction at the least distance allowed."""
    size = math.sqrt(z.real * z.real + z.imag * z.imag)
    return z if size >= least else z * (least / max(size, 1e-9))


@kernel()
def first_guess(w: Any, c: Any, least: Any) -> Any:
    """Return the larger root of z + c / z = w."""
    px = 0.25 * (w.real * w.real - w.imag * w.imag) - c.real
    py = 0.5 * w.real * w.imag - c.imag
    size = math.sqrt(px * px + py * py)
    rx = math.sqrt(max(0.5 * (size + px), 0.0))
    ry = math.copysign(math.sqrt(max(0.5 * (size - px), 0.0)), py)
    if w.real * rx + w.imag * ry < 0.0:
        rx, ry = -rx, -ry
    return kept_outside(complex(0.5 * w.real + rx, 0.5 * w.imag + ry), least)


@kernel()
def slope_at(scale: Any, series: Any, stride: Any, z: Any) -> Any:
    """Return f and f' at z."""
    back = inverse(z)
    s = back
    for _ in range(stride - 1):
        s = s * back
    value, slope = 0j, 0j
    for n in range(series.size - 1, -1, -1):
        value = s * value + series[n]
        slope = s * slope - (1 + n * stride) * series[n]
    return scale * z + back * value, scale + back * back * slope


@kernel(
    "void(float64,complex128[::1],int64,complex128[:,::1],float64,float64,float64,float64[::1],float64[::1],float64[::1],"
    "float64[::1],float64[::1],float64[:,::1],float64[:,::1])"
)
def fill_skirt(
    scale: Any,
    series: Any,
    stride: Any,
    by_size: Any,
    k: Any,
    least: Any,
    kink: Any,
    c: Any,
    x: Any,
    y: Any,
    sign: Any,
    fall: Any,
    by_rim: Any,
    basis: Any,
) -> None:
    """Fill the fall (n,), its derivatives (3 + shape, n) and the functions (COUNT, n) at places (n,) about the centre.

    The derivatives are by x, y and k, then by the shape's own parameters, of which row p of `by_size` tells how C and the
    series follow. `by_size` has a first row for k. `sign` is -1 where a place was mirrored into the outside, and 0 where
    it is too far inside to matter. The kink at the rim is rounded to (tau + width)^2 / (4 width), which keeps the line
    outside as it is.
    """
    sine, cosine = np.empty(HARMONIC + 1), np.empty(HARMONIC + 1)
    powers = np.empty(by_size.shape[1], dtype=np.complex128)
    radial, rise = np.empty(HARMONIC + 1), np.empty(HARMONIC + 1)
    for n in range(x.size):
        fall[n] = 0.0
        by_rim[:, n] = 0.0
        basis[:, n] = 0.0
        if sign[n] == 0.0:
            continue
        w = complex(x[n], y[n] / k)
        z = first_guess(w * (1.0 / scale), series[0] * (1.0 / scale), least)
        slope = 0j
        for _ in range(TURNS):
            value, slope = slope_at(scale, series, stride, z)
            step = (value - w) * inverse(slope)
            new = kept_outside(z - step, least)
            step = new - z
            z = new
            if step.real * step.real + step.imag * step.imag < MET:
                break
        size = math.sqrt(slope.real * slope.real + slope.imag * slope.imag)
        turn = inverse(z * slope) * (1.0 / max(1.0, FLATTEST * scale / max(size, 1e-12 * scale)))
        radius = math.sqrt(z.real * z.real + z.imag * z.imag)
        tau = sign[n] * math.log(radius)
        width = kink * min(math.sqrt(turn.real * turn.real + (turn.imag / k) ** 2), STEEPEST)
        if tau <= -width:
            continue
        t, bent = tau, 1.0
        if tau < width:
            t, bent = (tau + width) * (tau + width) / (4.0 * width), (tau + width) / (2.0 * width)
        if t > FARTHEST:
            t, bent = FARTHEST, 0.0
        unit, grow = z * (1.0 / radius), math.exp(t)
        power, around = 1.0, 1.0 + 0j
        radial[0], rise[0], cosine[0], sine[0] = t, 1.0, 1.0, 0.0
        for m in range(1, HARMONIC + 1):
            power, around = power * grow, around * unit
            radial[m], rise[m] = (power - 1.0 / power) / (2.0 * m), 0.5 * (power + 1.0 / power)
            cosine[m], sine[m] = around.real, around.imag
        along, turned = 0.0, 0.0
        row = 0
        for varying in range(2):
            for m in range((VARYING if varying else HARMONIC) + 1):
                r, steep = radial[m], rise[m]
                if varying:
                    r, steep = 0.5 * t * t, t
                basis[row, n] = r * cosine[m]
                along += c[row] * steep * cosine[m]
                turned -= c[row] * m * r * sine[m]
                row += 1
                if m:
                    basis[row, n] = r * sine[m]
                    along += c[row] * steep * sine[m]
                    turned += c[row] * m * r * cosine[m]
                    row += 1
        total = 0.0
        for m in range(row):
            total += c[m] * basis[m, n]
        fall[n] = total
        along *= bent
        # with the change p of log z, the fall changes by along Re p + turned Im p
        by_rim[0, n] = -(along * turn.real + turned * turn.imag)
        by_rim[1, n] = (along * turn.imag - turned * turn.real) / k
        back = inverse(z)
        s = back
        for _ in range(stride - 1):
            s = s * back
        powers[0], powers[1] = z, back
        for m in range(2, powers.size):
            powers[m] = powers[m - 1] * s
        for p in range(by_size.shape[0]):
            moved = complex(0.0, w.imag / k) if p == 0 else 0j
            for m in range(powers.size):
                moved += by_size[p, m] * powers[m]
            change = -moved * turn
            by_rim[2 + p, n] = along * change.real + turned * change.imag
