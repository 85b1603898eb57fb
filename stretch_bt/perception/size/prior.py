"""Prior of a membrane's skirt: how it follows from stretch, depth and size.

Presses of the sheet solver without noise, fitted by the same model, give for each the logarithm of the tension ratio, the
skirt's coefficients over the depth, and the error of the size. Their regression on stretch, depth and size is the mean
of the prior, the covariance of the residuals is its width, so that a membrane that differs is not forced.
`benchmarks/perception_skirt.py` and `benchmarks/perception_skirt_thick.py` make the files.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput

__all__ = ["SKIRTS", "Regression", "SkirtPrior", "features", "powers", "shipped_prior"]

Array = npt.NDArray[np.float64]

SKIRTS = {"thin": "skirt.json", "thick": "skirt_thick.json"}
SLACK, GAIN = 1e-3, 40.0  # m, 1/m: a press stretches a slack sheet by about GAIN depth^2


def features(stretch: Array, depth: Array, radius: Array) -> Array:
    """Return the variables of the regression, (3, n): logarithms that stay finite without stretch; lengths in m."""
    return np.array([np.log(stretch + SLACK + GAIN * depth**2), np.log(depth), np.log(radius)])


def powers(count: int, degree: int) -> npt.NDArray[np.int64]:
    """Return the exponents (terms, count) of all monomials of `count` variables up to a degree."""
    grid = np.stack(np.meshgrid(*[np.arange(degree + 1)] * count, indexing="ij"), axis=-1).reshape(-1, count)
    return np.asarray(grid[grid.sum(axis=1) <= degree], dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Regression:
    """Polynomials of normalised features within the range that was seen, and the covariance of their residuals.

    `use` are the features that it takes; `center`, `scale`, `low` and `high` (n,); `exponents` (terms, n);
    `coefficients` (terms, targets); `covariance` (targets, targets).
    """

    use: tuple[int, ...]
    center: Array
    scale: Array
    low: Array
    high: Array
    exponents: npt.NDArray[np.int64]
    coefficients: Array
    covariance: Array

    def mean(self, at: Array) -> tuple[Array, Array]:
        """Return the targets at features (3,), and their derivatives (targets, 3)."""
        from stretch_bt.perception.size.prior_kernel import fill_mean

        use, targets = list(self.use), self.coefficients.shape[1]
        mean, by_used, slopes = np.empty(targets), np.empty((targets, len(use))), np.zeros((targets, 3))
        parts = self.low, self.high, self.center, self.scale, self.exponents, self.coefficients
        fill_mean(at[use], *parts, mean, by_used)
        slopes[:, use] = by_used
        return mean, slopes


@dataclass(frozen=True, slots=True)
class SkirtPrior:
    """Prior of (ln tension ratio, coefficients over depth (7,), error of the radius over the fillet's) of a round contact.

    `known` is the regression on stretch, depth and radius, `unknown` the one on depth and radius alone.
    """

    known: Regression
    unknown: Regression

    def mean(self, stretch: float | None, depth: float, radius: float) -> tuple[Array, Array]:
        """Return the mean (9,) and its derivatives (9, 2) by depth and radius, per m."""
        slack = 0.0 if stretch is None else stretch
        depth, radius = max(depth, 1e-4), max(radius, 1e-4)
        chosen = self.unknown if stretch is None else self.known
        tension = slack + SLACK + GAIN * depth**2
        mean, slopes = chosen.mean(np.array([math.log(tension), math.log(depth), math.log(radius)]))
        by_depth = slopes[:, 0] * 2.0 * GAIN * depth / tension + slopes[:, 1] / depth
        return mean, np.column_stack([by_depth, slopes[:, 2] / radius])

    def covariance(self, stretch: float | None) -> Array:
        """Return the covariance (9, 9)."""
        return (self.unknown if stretch is None else self.known).covariance

    def to_json(self) -> str:
        """Return the text of a file that `from_json` reads."""
        parts = {
            name: {f: np.asarray(getattr(part, f)).tolist() for f in Regression.__slots__}
            for name, part in (("known", self.known), ("unknown", self.unknown))
        }
        return json.dumps(parts, indent=1)

    @classmethod
    def from_json(cls, text: str) -> SkirtPrior:
        """Read a prior; raises InvalidInput where the text is none."""
        try:
            parts = json.loads(text)
            return cls(*(_regression(parts[name]) for name in ("known", "unknown")))
        except (KeyError, TypeError, ValueError) as error:
            raise InvalidInput(
                f"this is no prior of a skirt as benchmarks/perception_skirt.py writes it: {error}"
            ) from None


def _regression(fields: dict[str, list[float]]) -> Regression:
    arrays = {name: np.asarray(fields[name], dtype=np.float64) for name in Regression.__slots__ if name != "use"}
    whole = {"exponents": np.asarray(fields["exponents"], dtype=np.int64), "use": tuple(int(u) for u in fields["use"])}
    return Regression(**{**arrays, **whole})  # type: ignore[arg-type]


@cache
def shipped_prior(skirt: str = "thin") -> SkirtPrior:
    """Return the prior of the hand's own sheet, 100 x 90 x 2 mm: without bending stiffness, `thin`, or with it, `thick`."""
    if skirt not in SKIRTS:
        raise InvalidInput(f"there is no skirt {skirt!r}; write one of {', '.join(SKIRTS)}")
    return SkirtPrior.from_json(resources.files(__package__).joinpath(SKIRTS[skirt]).read_text(encoding="utf-8"))
