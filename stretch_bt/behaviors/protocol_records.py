"""The records of a characterisation: the presses of its protocol, the presses left, and the table of the presses made."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from stretch_bt.behaviors._table import TableFile
from stretch_bt.model.calibration.protocol import Protocol, State, missing
from stretch_bt.units import Angle, Length

__all__ = ["Indenter", "Left", "ProtocolPlan", "Table", "Trial"]


@dataclass(frozen=True, slots=True)
class ProtocolPlan:
    """The presses of a protocol."""

    name: str  # name of the protocol
    presses: int  # number of presses
    max_stretch: Length  # largest stretch
    max_depth: Length  # largest depth

    @classmethod
    def of(cls, name: str, wanted: Protocol) -> ProtocolPlan:
        """Return the plan of a protocol."""
        return cls(name, sum(1 for _ in wanted.states()), wanted.stretches[-1], wanted.depths[-1])


@dataclass(frozen=True, slots=True)
class Trial:
    """Presses at one stretch, each deeper than the one before."""

    stretch: Length  # stretch past the rest length
    number: int  # number of the trial at this stretch, from 1
    depths: list[Length]  # depths of the hand past first contact


@dataclass(frozen=True, slots=True)
class Indenter:
    """An indenter with the trials to be made with it."""

    geometry: str  # sphere, cylinder or cone
    diameter: Length  # diameter of a sphere or cylinder; 0 for a cone
    angle: Angle  # angle of a cone between its surface and the membrane plane; else 0
    trials: list[Trial]  # trials in their order

    @property
    def size(self) -> float:
        """The angle of a cone, rad; the diameter of another indenter, m."""
        return self.angle if self.geometry == "cone" else self.diameter


@dataclass(frozen=True, slots=True)
class Left:
    """The presses that a table lacks."""

    presses: int  # number of presses
    indenters: list[Indenter]  # indenters in their order

    @classmethod
    def of(cls, wanted: Protocol, made: Iterable[State]) -> Left:
        """Return the presses of a protocol that no press made comes near."""
        states = missing(wanted, made)
        indenters = [_indenter(list(group)) for _, group in groupby(states, lambda state: state.indenter)]
        return cls(len(states), indenters)


def _indenter(states: list[State]) -> Indenter:
    first, cone = states[0], states[0].geometry == "cone"
    trials = [
        Trial(series[2], series[3], [state.depth for state in group])
        for series, group in groupby(states, lambda state: state.series)
    ]
    size, angle = (0.0, first.size) if cone else (first.size, 0.0)
    return Indenter(first.geometry, size, angle, trials)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of presses, which grows by one at a time."""

    rows: int  # presses that it holds
    content: TableFile  # the table
