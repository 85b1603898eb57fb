"""The common part of light objects that nothing holds in their place."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.objects.base import Moved, ObjectSpec, Specimen, Standing

if TYPE_CHECKING:
    from stretch_bt.simulation.effects.rigid_shift import RigidShift

__all__ = ["LooseSpec", "SlidingSpecimen"]

_STEP = 0.1  # s along the hand's path, which is straight in a step


class LooseSpec(ObjectSpec, ABC):
    """An object that its own weight alone holds in its place; it slides where the effect `rigid_shift` is on."""

    @property
    @abstractmethod
    def own_weight(self) -> float:
        """Its weight, N."""

    def specimen(self, effects: Active) -> Specimen:
        """Return the object as it is at the begin of a run, able to slide where that is switched on."""
        plain = super().specimen(effects)
        shift = effects.get("rigid_shift")
        return plain if shift is None else SlidingSpecimen(self, plain, shift)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class Slid:
    """Where an object stands, (x, y), m, how far the membrane is strained sideways over it, (x, y), m, and its own state."""

    place: tuple[float, float]
    strain: tuple[float, float]
    own: Any


class SlidingSpecimen(Specimen):
    """An object that the membrane can push over the table."""

    def __init__(self, spec: LooseSpec, plain: Specimen, shift: RigidShift) -> None:
        super().__init__(spec, plain.response)
        self.plain, self.shift, self.weight = plain, shift, spec.own_weight

    @property
    def memory(self) -> float:
        """Steps, s, that are short beside a turn of the hand's path, or its own if they are shorter."""
        own = self.plain.memory
        return _STEP if own is None else min(own, _STEP)

    @property
    def timeless(self) -> bool:
        """Whether its own answer does not depend on time: it slides with the hand alone."""
        return self.plain.timeless

    def start(self, seed: int = 0) -> Slid:
        """Return the state where the scene has the object."""
        place = self.spec.position
        return Slid((place.x, place.y), (0.0, 0.0), self.plain.start())

    def law(self, state: Slid, dt: float) -> Any:
        """Return the force of the object itself."""
        return self.plain.law(state.own, dt)

    def kinks(self, state: Slid) -> Any:
        """Return the object's own."""
        return self.plain.kinks(state.own)

    def drop(self, state: Slid) -> float:
        """Return the object's own, m."""
        return self.plain.drop(state.own)

    def rest(self, state: Slid, dt: float) -> float:
        """Return the object's own, m."""
        return self.plain.rest(state.own, dt)

    def standing(self, state: Slid, drop: float) -> Standing:
        """Return the body that the membrane meets after a drop of its top, m, where the object is now."""
        return replace(self.plain.standing(state.own, drop), x=state.place[0], y=state.place[1])

    def after(self, state: Slid, moved: Moved) -> Slid:
        """Return its state after a step, slid as far as friction lets it."""
        slip, strain = self.shift.slide(state.strain, moved, self.weight)
        place = state.place[0] + slip[0], state.place[1] + slip[1]
        return Slid(place, strain, self.plain.after(state.own, moved))

    def known(self, state: Slid, drop: float) -> dict[str, float]:
        """Return its true quantities now, SI."""
        return self.plain.known(state.own, drop)
