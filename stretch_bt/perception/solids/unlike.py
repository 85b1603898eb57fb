"""Whether the outline of a flat top agrees with the shape that explains it best."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.robust import MAD_TO_SD
from stretch_bt.perception.solids.outline import Fitted

__all__ = ["unlike_circle", "unlike_rectangle"]

Array = npt.NDArray[np.float64]

HARMONICS = np.arange(2, 9)
FEWEST = 24  # bends around a top that show its harmonics
ALIKE = 4.0  # bends that err as one
ROUNDS = 10  # of weights
MISSED = 0.1e-3  # m, error of a harmonic of the bends around a disc (0.01 to 0.14 mm; `python benchmarks/flat_tops.py`)
CLEAR = 12.0  # chi2 of two degrees of freedom
END = 0.6  # share of half a side from its middle to where its bow is taken
INNER = 0.7  # of half a side: beyond it the membrane falls off to two sides
ON = 0.6  # of half a width, from where a bend belongs to a side
LEAST = 4  # bends of a side
BOWED = 1e-3  # m, median bow of the sides: of blocks mostly less than 0, of single ones up to 0.7 mm, of ellipses 1.9 to 2.9


def unlike_circle(places: Array, circle: Fitted) -> str:
    """Return why the outline through places (n, 2), m, is no circle; nothing where it may be one."""
    if len(places) < FEWEST:
        return ""
    x, y = (places - circle.middle).T
    angle, off = np.arctan2(y, x), np.hypot(x, y) - circle.sizes[0]
    waves = [wave(n * angle) for n in HARMONICS for wave in (np.cos, np.sin)]
    design = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle), *waves])
    weights = np.ones(len(off))
    for _ in range(ROUNDS):
        gain = np.linalg.pinv((design * weights[:, None]).T @ design)
        found = gain @ (design.T @ (weights * off))
        left = off - design @ found
        sd = MAD_TO_SD * float(np.median(np.abs(left))) + 1e-6
        weights = 1.0 / (1.0 + (left / (2.0 * sd)) ** 2)
    pairs = found[3:].reshape(-1, 2)
    variances = ALIKE * sd**2 * np.diag(gain)[3:].reshape(-1, 2).mean(axis=1)
    chi2 = (pairs**2).sum(axis=1) / (variances + MISSED**2)
    clearest = int(np.argmax(chi2))
    if chi2[clearest] < CLEAR:
        return ""
    by, count = 1e3 * math.hypot(*pairs[clearest]), HARMONICS[clearest]
    return f"the outline is no circle: it stands {by:.1f} mm outside the best one, and as much inside, in {count} places around it"


def unlike_rectangle(places: Array, rectangle: Fitted) -> str:
    """Return why the outline through places (n, 2), m, is no rectangle; nothing where it may be one."""
    c, s = math.cos(rectangle.heading), math.sin(rectangle.heading)
    x, y = np.array([[c, s], [-s, c]]) @ (places - rectangle.middle).T
    first, second = rectangle.sizes
    sides = ((x, y, first, second), (-x, y, first, second), (y, x, second, first), (-y, x, second, first))
    bows = [bow for out, along, half, across in sides if (bow := _bow(out, along, half, across)) is not None]
    if len(bows) < len(sides) or np.median(bows) < BOWED:
        return ""
    return f"the outline is no rectangle: the middles of its sides stand {1e3 * float(np.median(bows)):.1f} mm outside their ends"


def _bow(out: Array, along: Array, half: float, across: float) -> float | None:
    """Return how far the middle of a side stands outside its ends, m; None where too little of it is seen."""
    on = (out > ON * half) & (np.abs(along) < INNER * across)
    if np.count_nonzero(on) < LEAST:
        return None
    at = along[on] / across
    design = np.column_stack([np.ones_like(at), at, at * at])
    return -(END**2) * float(np.linalg.lstsq(design, out[on], rcond=None)[0][2])
