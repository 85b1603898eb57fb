"""Prior of the skirt around a rectangular contact, by stretch, depth, sides, turn and place.

As for round contacts (prior.py), but fitted with the sides held at the truth, so that the coefficients take up the
model's residual. Terms are sorted by how they change when the membrane is mirrored across i or along j: only those that change
alike can go with a coefficient, whatever the sheet. `benchmarks/perception_skirt_rectangle.py` makes the file.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.size.around import ORDERS
from stretch_bt.perception.size.prior import GAIN, SLACK

__all__ = [
    "TARGETS",
    "BoxPrior",
    "BoxRegression",
    "box_terms",
    "looseness",
    "matching",
    "shipped_box_prior",
    "steady_terms",
]

Array = npt.NDArray[np.float64]

TARGETS = 1 + len(ORDERS)  # ln ratio, then coefficients over the depth
EVEN, ODD_X, ODD_Y, ODD_BOTH = range(4)
LOW = np.array([-12e-3, -12e-3, 6e-3, 6e-3, -np.inf, 1.5e-3])  # x, y, sides, rotation, depth
HIGH = np.array([12e-3, 12e-3, 36e-3, 36e-3, np.inf, 18e-3])
FARTHEST = 70e-3  # m of stretch


def box_terms(sizes: Array, stretch: float | Array | None) -> tuple[Array, npt.NDArray[np.int64]]:
    """Return the terms (n, terms) of the regression and the mirror class of each (terms,).

    Parameters
    ----------
    sizes : (n, 6)
        x, y, first side, second side, m, rotation of the first, rad, depth, m; clipped to the range that was seen.
    stretch : float or (n,), m, or None
        None leaves the terms with the stretch out.
    """
    x, y, first, second, rotation, depth = np.clip(sizes, LOW, HIGH).T
    c, s = np.cos(rotation), np.sin(rotation)
    xx, yy = (first * c) ** 2 + (second * s) ** 2, (first * s) ** 2 + (second * c) ** 2
    size, d = 0.5 * np.log(first * second / 4e-4), np.log(depth / 8e-3)
    wide = (xx - yy) / (xx + yy)
    turned = 2.0 * (first**2 - second**2) * c * s / (xx + yy)
    aspect = 2.0 * first * second / (xx + yy)
    diamond, tilted = aspect * np.cos(4.0 * rotation), aspect * np.sin(4.0 * rotation)
    a, b, one = x / 10e-3, y / 10e-3, np.ones_like(x)
    even = [
        one,
        d,
        size,
        wide,
        d * d,
        size**2,
        wide**2,
        d * size,
        d * wide,
        size * wide,
        turned**2,
        a * a,
        b * b,
        diamond,
    ]
    even += [d**3, d * diamond, size * diamond, wide * diamond, wide**3, wide**2 * d, wide * turned**2, size * wide**2]
    odd_x, odd_y = (
        [p, p * d, p * size, p * wide, o * turned, p * d * d, p**3, p * o * o, p * wide**2] for p, o in ((a, b), (b, a))
    )
    odd_both = [
        turned,
        turned * d,
        turned * size,
        turned * wide,
        a * b,
        turned * d * d,
        turned * size**2,
        turned * wide**2,
    ]
    odd_both += [turned**3, tilted]
    if stretch is not None:
        t = np.log((np.clip(stretch, 0.0, FARTHEST) + SLACK + GAIN * depth**2) / 40e-3)
        even += [t, t * t, t * d, t * size, t * wide, t**3, t * t * d, t * d * d]
        even += [t * t * size, t * t * wide, t * d * size, t * d * wide, t * diamond, wide**2 * t]
        odd_x, odd_y = ([*odd, p * t, p * t * t, p * t * d] for odd, p in ((odd_x, a), (odd_y, b)))
        odd_both += [turned * t, turned * t * t, turned * t * d]
    groups = (even, odd_x, odd_y, odd_both)
    classes = np.repeat(np.arange(4), [len(g) for g in groups])
    return np.column_stack([term for group in groups for term in group]), classes


def steady_terms(depth: float | Array, stretch: float | Array | None) -> Array:
    """Return the terms (n, 3 or 6) that the steady part of the fits' error follows, for depths and stretches in m."""
    d = np.clip(np.atleast_1d(depth), LOW[5], HIGH[5]) / 10e-3
    terms = [np.ones_like(d), d, d * d]
    if stretch is not None:
        t = np.clip(np.atleast_1d(stretch), 0.0, FARTHEST) / 40e-3 * np.ones_like(d)
        terms += [t, t * t, t * d]
    return np.column_stack(terms)


def looseness(stretch: float | Array) -> Array:
    """Return the stretch, m, plus 5 mm, over the same at a stretch of 35 mm."""
    return (np.clip(stretch, 0.0, FARTHEST) + 5e-3) / 40e-3


def matching() -> npt.NDArray[np.int64]:
    """Return the mirror class of each target (TARGETS,)."""
    found = [EVEN]
    for _, n, part in ORDERS:
        by_x, by_y = n % 2 == 1, part == "s"
        found.append(ODD_BOTH if by_y and not by_x else EVEN if not by_x else ODD_Y if by_y else ODD_X)
    return np.array(found)


@dataclass(frozen=True, slots=True)
class BoxRegression:
    """Coefficients (terms, TARGETS) of the terms, and the covariance (TARGETS, TARGETS) of their residuals at 35 mm of stretch.

    The deviations of each target go with `slack` (TARGETS,) powers of the stretch plus 5 mm: a slack sheet is less alike.
    `steady` (terms of `steady_terms`, 2) is the correction of a side along i and of one along j, m.
    """

    coefficients: Array
    covariance: Array
    slack: Array
    steady: Array


@dataclass(frozen=True, slots=True)
class BoxPrior:
    """Prior of ln ratio and the coefficients over the depth, with the stretch known and unknown.

    `systematic` (5,) is the rms error of fits without noise beyond the steady part: x, y, a side along i, one along j, m, and the rotation, rad;
    `free_form` (2,) is the error of a free outline's fits along i and j, m.
    """

    known: BoxRegression
    unknown: BoxRegression
    systematic: Array
    free_form: Array

    def chosen(self, stretch: float | None) -> BoxRegression:
        """Return the regression for a stretch, m, or for None."""
        return self.unknown if stretch is None else self.known

    def mean(self, sizes: Array, stretch: float | None) -> Array:
        """Return the means (n, TARGETS) for rows of x, y, sides, m, rotation, rad, and depth, m."""
        return np.asarray(box_terms(sizes, stretch)[0] @ self.chosen(stretch).coefficients)

    def covariance(self, stretch: float | None) -> Array:
        """Return the covariance (TARGETS, TARGETS)."""
        part = self.chosen(stretch)
        deviations = looseness(0.0 if stretch is None else stretch) ** part.slack
        return part.covariance * np.outer(deviations, deviations)

    def steady(self, depth: float, stretch: float | None) -> Array:
        """Return the correction of a side along i and of one along j (2,), m."""
        return np.asarray(steady_terms(depth, stretch)[0] @ self.chosen(stretch).steady)

    def to_json(self) -> str:
        """Return the text of a file that `from_json` reads."""
        parts = {
            name: {field: _rounded(getattr(part, field)) for field in BoxRegression.__slots__}
            for name, part in (("known", self.known), ("unknown", self.unknown))
        }
        return json.dumps({**parts, "systematic": _rounded(self.systematic), "free_form": _rounded(self.free_form)})

    @classmethod
    def from_json(cls, text: str) -> BoxPrior:
        """Read a prior; raises InvalidInput where the text is none."""
        try:
            fields = json.loads(text)
            known, unknown = (
                BoxRegression(*(np.array(fields[name][f], dtype=np.float64) for f in BoxRegression.__slots__))
                for name in ("known", "unknown")
            )
            systematic, free_form = (np.array(fields[f], dtype=np.float64) for f in ("systematic", "free_form"))
            return cls(known, unknown, systematic, free_form)
        except (KeyError, TypeError, ValueError) as error:
            raise InvalidInput(
                f"this is no prior of a rectangle's skirt as benchmarks/perception_skirt_rectangle.py writes it: {error}"
            ) from None


def _rounded(values: Array) -> list[object]:
    return np.vectorize(lambda v: float(f"{v:.8g}"))(values).tolist()  # type: ignore[no-any-return]


@lru_cache(maxsize=1)
def shipped_box_prior() -> BoxPrior:
    """Return the prior of the hand's own sheet, 100 x 90 x 2 mm."""
    return BoxPrior.from_json(resources.files(__package__).joinpath("box_skirt.json").read_text(encoding="utf-8"))
