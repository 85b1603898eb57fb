"""What a shape must say to be fitted to a contact, and the shapes there are."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.size.prior import SkirtPrior
from stretch_bt.perception.size.start import Start

__all__ = ["HYPOTHESES", "Context", "FittedSizes", "Hypothesis", "hypothesis"]

Array = npt.NDArray[np.float64]
Value = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Context:
    """Prior knowledge beside the frame, lengths in m: the membrane's stretch, the object's fillet and the skirt's prior."""

    stretch: float | None
    fillet: float
    fillet_sd: float
    prior: SkirtPrior


@dataclass(frozen=True, slots=True)
class FittedSizes:
    """Sizes of a fitted shape, SI, as (value, sd); `sides` is None for round shapes, `rotation` is the first side's.

    `diameter_i` and `diameter_j` are the widths along i and j through the centre, of the object itself: to the ends of
    its edge fillet, not of the contact.
    """

    center: tuple[Value, Value]
    diameter_i: Value
    diameter_j: Value
    depth: Value
    sides: tuple[Value, Value] | None = None
    rotation: Value | None = None


class Hypothesis(Protocol):
    """A shape with its skirt, ready to fit: made anew for each contact with its `Context`.

    Parameters q (p,) are in SI, in an order of the shape's own. All Jacobians are (p, n).
    """

    name: str
    ratio: int  # place in q of the logarithm of the tensions' ratio
    handicap: float  # least improvement of its residuals over a simpler shape's, rms, as a share of the depth

    def starts(self, start: Start) -> list[Array]:
        """Return the parameters to start from, best guess first."""
        ...

    def scales(self, q: Array) -> Array:
        """Return the largest step (p,) that is allowed at once."""
        ...

    def model(self, q: Array, x: Array, y: Array) -> tuple[Array, Array]:
        """Return heights (n,), m, at places (n,), m, and their Jacobian."""
        ...

    def prior(self, q: Array) -> tuple[Array, Array]:
        """Return the residuals (r,) of q to the prior, in standard deviations, and their Jacobian (p, r)."""
        ...

    def log_prior(self, q: Array) -> float:
        """Return the logarithm of the whole prior density at q, SI, but for x, y, height and one size.

        Those four are as likely anywhere, for all shapes alike. The residuals that `prior` returns are part of it.
        """
        ...

    def satisfied(self, q: Array) -> bool:
        """Return whether a fit is so likely that no other start needs to be tried."""
        ...

    def outside(self, q: Array, x: Array, y: Array) -> Array:
        """Return how far places lie outside the rim, m, negative inside."""
        ...

    def measure(self, q: Array, covariance: Array) -> FittedSizes:
        """Return the sizes of a fitted shape; raises IllConditioned where q is no such shape."""
        ...


HYPOTHESES = {
    "circle": "Circle",
    "ellipse": "Ellipse",
    "rectangle": "Rectangle",
    "free_form": "FreeForm",
}  # name and module: class


def hypothesis(name: str, context: Context) -> Hypothesis:
    """Return the hypothesis of a name."""
    if name not in HYPOTHESES:
        raise InvalidInput(f"hypothesis is 'auto' or one of {', '.join(sorted(HYPOTHESES))}, got {name!r}")
    made: Any = getattr(import_module(f"stretch_bt.perception.size.{name}"), HYPOTHESES[name])
    return made(context)  # type: ignore[no-any-return]
