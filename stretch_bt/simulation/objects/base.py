"""An object: its options in a scene file, its undeformed shape, and its state in a run.

A new object is one file in this folder with one subclass of ObjectSpec. Importing it must stay cheap: modules that need numba or scipy
are imported where they are used.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.effects.base import ObjectEffect
from stretch_bt.simulation.objects.response import Law, Response
from stretch_bt.units import Angle, Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.hanging import Grip
    from stretch_bt.simulation.membrane.indenters.base import Indenter
    from stretch_bt.simulation.membrane.indenters.several import Several

__all__ = ["HertzForm", "Holds", "Moved", "ObjectSpec", "Point", "Rough", "Specimen", "Standing", "turned_aspect"]

_ROUND = 0.99  # of the radius of the disc of its area, which half the shorter side of a square top is less than

Holds = Literal["rim", "crest", "ridge", "dome", "point"]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Point(_Model):
    """A place on the table, world x and y, m."""

    x: Annotated[Length, Within(-1.0, 1.0, "Length")] = 0.0
    y: Annotated[Length, Within(-1.0, 1.0, "Length")] = 0.0


@dataclass(frozen=True, slots=True)
class HertzForm:
    """The closed form that stands in for an object at `hertz` fidelity: `sphere`, `cylinder` or `plane`, and its radius, m."""

    kind: str
    radius: float


@dataclass(frozen=True, slots=True)
class Rough:
    """Rough numbers of an object for the advisor: the radius of its top, m, its stiffness, N/m, and its weight, N.

    `edge` is the smallest radius of curvature that the membrane meets, m; `loose` whether it can slide over the table; `face`
    the radius of the disc that its flat top, its ridge or its outline is as wide as, m, 0 for a round top. `holds` is the part that
    holds a membrane up: the `rim` of a flat top or of a wire, a round `crest`, a sharp `ridge`, a `dome`, or a `point` on flanks of
    slope `steep`. `aspect` is the extent of its top towards the clamps over the one across, of a hand that is not turned. `flattens`
    says that a press may leave its top flat for good, and `several` that others stand beside it, between which the membrane hangs freely.
    """

    radius: float
    stiffness: float = math.inf
    weight: float = math.inf
    edge: float = math.inf
    loose: bool = False
    face: float = 0.0
    holds: Holds = "dome"
    steep: float = math.inf
    aspect: float = 1.0
    flattens: bool = False
    several: bool = False

    @property
    def cornered(self) -> bool:
        """Whether its flat top has corners: one that is round is as wide in its shorter direction as the disc of its area."""
        return self.holds == "rim" and 2 * self.edge < self.radius < _ROUND * self.face


def turned_aspect(length: float, width: float, heading: float) -> float:
    """Return the extent along y over the one along x of a rectangle, its length, m, along x before it is turned by a heading, rad."""
    c, s = abs(math.cos(heading)), abs(math.sin(heading))
    return (length * s + width * c) / (length * c + width * s)


@dataclass(frozen=True, slots=True)
class Standing:
    """The object that the membrane meets: a body whose axis stands at (x, y), turned by `heading`, its highest point at `top`; m, rad.

    There is no body where only a closed form can stand in for it. A `felt` body is a simpler one with nearly the same force,
    which stands in for it where its force is felt and its shape is not seen; `varies` says that the body changes with the drop,
    `passing` that it changes from look to look, so that a shape within 0.05 mm, solved in a third of the time, serves.
    """

    body: Indenter | Several | None
    x: float
    y: float
    heading: float
    top: float
    felt: Indenter | None = None
    varies: bool = False
    passing: bool = False


@dataclass(frozen=True, slots=True)
class Moved:
    """The course of a step: the drop of the top, m, the force on the object (3,), N, world axes, how far the hand moved
    across, (x, y), m, and for how long, s; `depth` is how deep the object stands in the membrane, m. `raised` is how far it hangs
    above where it stood, m, while the membrane pulls at it, None while it does not.
    """

    drop: float
    force: tuple[float, float, float]
    across: tuple[float, float]
    dt: float
    depth: float
    raised: float | None = None


class ObjectSpec(_Model):
    """Options and shape that every object has."""

    #: object effects that it can have
    effects: ClassVar[tuple[str, ...]] = ()

    type: str
    position: Point = Field(default=Point(), description="place of its axis on the table")
    heading: Angle = Field(default=0.0, description="turn about its axis, counter-clockwise seen from above")
    base: Annotated[Length, Within(0.0, 0.5, "Length")] = Field(
        default=0.0, description="height of its lowest point above the table"
    )

    @property
    def noun(self) -> str:
        """What messages call it."""
        return f"a {self.type}"

    @property
    @abstractmethod
    def top(self) -> float:
        """World height of the undeformed top, m."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """How far from its axis it reaches, m; infinite when it is wider than any membrane."""

    @property
    def hertz(self) -> HertzForm | None:
        """The closed form that stands in for it at `hertz` fidelity, None where there is none."""
        return None

    @abstractmethod
    def body(self) -> Indenter | Several | None:
        """Return its undeformed shape, as the membrane meets it: z up, and y against the world's, as in the membrane frame.

        None where only a closed form can stand in for it.
        """

    @abstractmethod
    def rough(self) -> Rough:
        """Return its rough numbers for the advisor."""

    def compliance(self) -> Response | None:
        """Return how it gives way, None when it is rigid."""
        return None

    def known(self) -> dict[str, float]:
        """Return its true quantities, SI, such as its `radius` and its `stiffness`."""
        return {}

    def located(self, folder: Path) -> ObjectSpec:
        """Return the object with the files it names found from a folder, its scene file's, once its shape has been made.

        Raises
        ------
        InvalidInput
            Its sizes make no shape; a file cannot be read, or holds none.
        """
        self.body()
        return self

    def specimen(self, effects: Active) -> Specimen:
        """Return the object as it is at the begin of a run, with the effects that are on."""
        response: Response | None = None
        for effect in effects.of(ObjectEffect):  # type: ignore[type-abstract]
            response = effect.respond(response, self)
        return Specimen(self, response)


class Specimen:
    """An object in a run; one that changes its shape or its place is a subclass. States are values that never change."""

    def __init__(self, spec: ObjectSpec, response: Response | None) -> None:
        self.spec = spec
        self.response = response

    @property
    def memory(self) -> float | None:
        """None where its answer depends on where the hand is alone; else its response's memory."""
        return None if self.response is None else self.response.memory

    @property
    def timeless(self) -> bool:
        """Whether nothing changes while the hand stands still."""
        return self.memory is None or math.isinf(self.memory)

    def start(self, seed: int = 0) -> Any:
        """Return its state at the begin; `seed` is the seed of its chances."""
        return None if self.response is None else self.response.start()

    def law(self, state: Any, dt: float) -> Law | None:
        """Return its force by the drop of its top at the end of a step, None when it is rigid."""
        return None if self.response is None else self.response.law(state, dt)

    def kinks(self, state: Any) -> Sequence[float]:
        """Return the drops, m, at which the slope of its force jumps."""
        return () if self.response is None else self.response.kinks(state)

    def drop(self, state: Any) -> float:
        """Return the drop that it has, m, before the next step; of use to an object whose force may fall."""
        return 0.0 if self.response is None else self.response.drop(state)

    def rest(self, state: Any, dt: float) -> float:
        """Return the drop up to which it stays down by itself after `dt`, s; m."""
        return 0.0 if self.response is None else self.response.rest(state, dt)

    def grip(self, state: Any) -> Grip | None:
        """Return how it sticks to the membrane, None where it does not."""
        return None

    def sketch(self, state: Any) -> dict[str, list[tuple[float, float]]]:
        """Return closed lines, m, that show an object which changes its shape for good: `side`, by x and height, and `outline`, by x and y."""
        return {}

    def form(self, standing: Standing) -> HertzForm | None:
        """Return the closed form that stands in for it at `hertz` fidelity."""
        return self.spec.hertz

    def standing(self, state: Any, drop: float) -> Standing:
        """Return the body that the membrane meets after a drop of its top, m.

        Raises
        ------
        NoEquilibrium
            The drop would press it flat.
        """
        spec = self.spec
        if drop >= spec.top - spec.base:
            raise NoEquilibrium(f"a drop of {drop * 1e3:.3g} mm would press the object flat")
        return Standing(spec.body(), spec.position.x, spec.position.y, spec.heading, spec.top - drop)

    def after(self, state: Any, moved: Moved) -> Any:
        """Return its state after a step."""
        return state if self.response is None else self.response.after(state, moved.drop, moved.dt)

    def known(self, state: Any, drop: float) -> dict[str, float]:
        """Return its true quantities now, at a drop of its top, m; SI. An object that does not give way has no stiffness."""
        known = self.spec.known()
        if self.response is None:
            known.pop("stiffness", None)
        return known
