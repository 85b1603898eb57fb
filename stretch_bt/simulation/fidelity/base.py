"""The interface of a fidelity: the force of the membrane on a body that it meets, and its shape.

A new one is one file in this folder and one line in `make`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.camera.skin import Skin
from stretch_bt.simulation.objects.base import HertzForm
from stretch_bt.simulation.objects.response import Law

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.base import Indenter
    from stretch_bt.simulation.membrane.indenters.several import Several

Array = npt.NDArray[np.float64]

__all__ = ["Fidelity", "Place", "Pressed"]


@dataclass(frozen=True, slots=True)
class Place:
    """A body at its place in the membrane frame, and its closed form, if there is one; lengths in m, angles in rad.

    Its axis is at `at`, turned by `heading` about z and then by `tilt` about x and y; `reach` is how far from it the body
    goes; `varies` says that the body changes a little from press to press, `passing` that its shape is needed within 0.05 mm
    alone. The depth, from the flat membrane to its highest point, is asked for separately.
    """

    body: Indenter | Several | None
    form: HertzForm | None
    at: tuple[float, float]
    heading: float
    tilt: tuple[float, float]
    reach: float
    stretch: float
    varies: bool = False
    passing: bool = False


@dataclass(frozen=True, slots=True)
class Pressed:
    """A membrane in equilibrium: its shape, and its memory for another press."""

    skin: Skin
    state: Any = None


@runtime_checkable
class Fidelity(Protocol):
    """Stands in for the membrane."""

    #: whether a press depends on those before it
    remembers: bool
    #: relative accuracy of its forces: they need to agree no better with the object's
    close: float

    def law(self, place: Place, state: Any) -> Law:
        """Return the force, N, along z, and its slope, N/m, by depth, m.

        Raises
        ------
        NoEquilibrium
            Also on calling the law: the membrane has no equilibrium at that place or depth.
        """
        ...

    def force(self, place: Place, depth: float, state: Any) -> Array:
        """Return the force (3,), N, membrane frame, on the membrane at a depth, m."""
        ...

    def press(self, place: Place, depth: float, state: Any) -> Pressed:
        """Return the membrane at a depth, m; `state` is an earlier press' state, or None."""
        ...

    def released(self, state: Any) -> Any:
        """Return the membrane's memory of a press once it no longer touches."""
        ...

    def lift(self, place: Place) -> float:
        """Return how far the free membrane hangs below its plane at a place, m: at minus that depth it touches first."""
        ...

    def free(self, stretch: float) -> Skin:
        """Return the shape of the membrane while nothing touches it."""
        ...
