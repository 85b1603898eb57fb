"""Several objects that stand side by side."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field, TypeAdapter, WithJsonSchema, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.base import ObjectSpec, Rough
from stretch_bt.simulation.objects.solid import SolidSpec

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.several import Several

__all__ = ["SeveralObjects"]

_UNDER = 0.100  # m from its middle that a membrane reaches along the stretch, at a stretch of 100 mm


def _kind(given: Any) -> Any:
    """Return the object of one entry; the kinds are looked up late, as this is one of them."""
    from stretch_bt.simulation.objects.registry import kinds

    if isinstance(given, ObjectSpec):
        return given
    name = given.get("type") if isinstance(given, dict) else None
    known = [kind for kind in kinds() if kind != "several"]
    if name not in known:
        raise InvalidInput(f"each object has a type; write one of {', '.join(known)}")
    return TypeAdapter(kinds()[name]).validate_python(given)


def _gives_way(thing: ObjectSpec) -> str:
    """Return what of an object gives way, and the remedy."""
    if isinstance(thing, SolidSpec):
        return f"a {thing.type} gives way where it has a stiffness; write 'rigid: true' for it"
    return f"a {thing.type} gives way; leave it out, or write a solid with 'rigid: true' in its place"


_One = Annotated[Any, BeforeValidator(_kind), WithJsonSchema({"type": "object", "required": ["type"]})]


class SeveralObjects(ObjectSpec):
    """Rigid objects that stand side by side; their positions count from the position of the whole, which turns them about it."""

    type: Literal["several"]
    objects: Annotated[list[_One], Field(min_length=2, max_length=20)]

    @model_validator(mode="after")
    def _rigid_bodies(self) -> SeveralObjects:
        for thing in self.objects:
            if thing.compliance() is not None or math.isfinite(thing.rough().stiffness):
                raise InvalidInput(f"objects that stand side by side are rigid, and {_gives_way(thing)}")
            if thing.type == "plane":
                raise InvalidInput(
                    "nothing stands beside an object that is wider than the membrane; leave out the plane"
                )
        return self

    def located(self, folder: Path) -> SeveralObjects:
        """Return the objects with their files found from a folder."""
        return self.model_copy(update={"objects": [thing.located(folder) for thing in self.objects]})

    @property
    def noun(self) -> str:
        """What messages call them."""
        return "several objects"

    @property
    def top(self) -> float:
        """World height of the highest of them, m."""
        return self.base + max(float(thing.top) for thing in self.objects)

    @property
    def reach(self) -> float:
        """How far the furthest reaches from the axis, m."""
        return max(float((thing.position.x**2 + thing.position.y**2) ** 0.5 + thing.reach) for thing in self.objects)

    def body(self) -> Several:
        """Return all their bodies."""
        from stretch_bt.simulation.membrane.indenters.several import Part, Several
        from stretch_bt.simulation.membrane.indenters.turned import turn

        parts: list[Part] = []
        highest = max(float(thing.top) for thing in self.objects)
        for thing in self.objects:
            # bodies have the y of the membrane frame, which is reversed against the world's
            body, below = turn(thing.body(), -thing.heading), highest - thing.top
            at = (thing.position.x, -thing.position.y)
            inner = body.parts if isinstance(body, Several) else (Part(body, (0.0, 0.0)),)
            parts += [Part(p.indenter, (at[0] + p.at[0], at[1] + p.at[1]), below + p.below) for p in inner]
        return Several(tuple(parts))

    def rough(self) -> Rough:
        """Return the rough numbers of the highest of them, with the smallest edge of all."""
        highest: Rough = max(self.objects, key=lambda thing: thing.top).rough()
        edge = min(thing.rough().edge for thing in self.objects)
        return replace(highest, stiffness=math.inf, weight=math.inf, edge=edge, loose=False, several=self._beside())

    def _beside(self) -> bool:
        """Return whether a membrane over one of them also meets another."""
        pairs = combinations(self.objects, 2)
        return any(
            math.dist((one.position.x, one.position.y), (two.position.x, two.position.y)) - max(one.reach, two.reach)
            < _UNDER
            for one, two in pairs
        )
