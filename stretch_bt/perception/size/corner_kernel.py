"""The Schwarz-Christoffel map of the outside of a parallelogram, compiled; exterior.py says what it is."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["fill_maps"]

TURNS = 12
MET = 1e-13
STEP = 1e-4


@kernel()
def length_between(between: Any, p: Any, q: Any, nodes: Any, weights: Any) -> Any:
    """Return the length, over C, of the image of the arc of the unit circle between two corners."""
    total = 0.0
    for n in range(nodes.size):
        first, second = 2.0 * math.sin(between * nodes[n]), 2.0 * math.sin(between * (1.0 - nodes[n]))
        total += weights[n] * math.exp(p * math.log(max(first, 1e-300)) + q * math.log(max(second, 1e-300)))
    return between * total


@kernel()
def log_of_ratio(between: Any, p: Any, q: Any, nodes: Any, weights: Any) -> Any:
    """Return the logarithm of the ratio of the sides."""
    first = length_between(between, p, q, nodes, weights)
    return math.log(first / length_between(math.pi - between, q, p, nodes, weights))


@kernel("void(complex128[::1],complex128[::1],float64[::1],float64[::1],float64[::1],complex128[:,::1])")
def fill_maps(first: Any, second: Any, nodes: Any, weights: Any, scale: Any, series: Any) -> None:
    """Fill C (m,) and the series (m, TERMS) of parallelograms with these sides (m,), given a quadrature on 0..1."""
    for m in range(first.size):
        ratio = second[m] / first[m]
        q = math.atan2(ratio.imag, ratio.real) / math.pi
        p = 1.0 - q
        wanted = -math.log(abs(ratio))
        angle = math.pi / (1.0 + math.exp(-0.5 * wanted))
        for _ in range(TURNS):
            miss = log_of_ratio(angle, p, q, nodes, weights) - wanted
            slope = (log_of_ratio(angle + STEP, p, q, nodes, weights) - miss - wanted) / STEP
            new = min(max(angle - miss / slope, 0.5 * angle), 0.5 * (angle + math.pi - 2.0 * STEP))
            step, angle = new - angle, new
            if abs(step) < MET:
                break
        phase = 0.5 * math.pi * (1.0 + p - q) + 0.5 * angle * (q - p)
        length = length_between(angle, p, q, nodes, weights)
        edge = -first[m] / (length * complex(math.cos(phase), math.sin(phase)))
        scale[m] = abs(edge)
        square = (edge / scale[m]) * (edge / scale[m])
        # d_n of (1 - a s)^p (1 - b s)^q by the recursion that its derivative obeys, with a b = 1 and p + q = 1
        both, skew = 2.0 * math.cos(angle), complex(math.cos(angle), (q - p) * math.sin(angle))
        before, now, turned = 0j, 1.0 + 0j, complex(scale[m], 0.0)
        for n in range(series.shape[1]):
            new_now = ((both * n - skew) * now - (n - 2.0) * before) / (n + 1)
            before, now = now, new_now
            turned = turned * square
            series[m, n] = turned * now / (1.0 - 2.0 * (n + 1))
