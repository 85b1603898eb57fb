"""The limits of a cell, checked before a command is sent and while the arm moves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from stretch_bt.errors import BeyondLimits, InvalidInput, LimitExceeded
from stretch_bt.frames import Pose
from stretch_bt.hardware.asked import check_speed
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.past_limits import outside_limits, past_limit, remedy
from stretch_bt.hardware.slack import most_measured
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS, Force, Length, Speed, Stiffness, Time
from stretch_bt.within import Within

__all__ = ["LIMITED", "ContactLimit", "Limits", "Span"]

#: limits that a port may have, as in `port(limit="depth")`: names that `Limits.span` takes
LIMITED = (
    *("x", "y", "height", "speed", "gripper_speed", "depth", "stretch", "force"),
    *("contact_speed", "held_force", "lowered_force", "travel", "radius"),
)

_Place = Annotated[Length, Within(-10.0, 10.0, "Length")]
_ROUNDING = 1e-9


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Span(_Model):
    """A least and a greatest value, both allowed."""

    min: _Place
    max: _Place

    @model_validator(mode="after")
    def _ordered(self) -> Span:
        if not self.min < self.max:
            least, most = (format_quantity(v, KINDS["Length"]) for v in (self.min, self.max))
            raise InvalidInput(f"min {least} is not below max {most}; swap them")
        return self


class ContactLimit(_Model):
    """Where the hand may meet something, and how fast it may be there, in any direction."""

    below: _Place = Field(description="height of the hand under which it may meet something, where `contact` is given")
    speed: Annotated[Speed, Within(1e-4, 1.5, "Speed")] = Field(description="speed of the arm there, in any direction")


class Limits(_Model):
    """What no command may ask for, and the force at which the arm is stopped; heights are world z of the hand."""

    x: Span = Span.model_construct(min=-0.5, max=0.5)
    y: Span = Span.model_construct(min=-0.5, max=0.5)
    height: Span = Span.model_construct(min=0.0, max=0.6)
    speed: Annotated[Speed, Within(1e-4, 1.5, "Speed")] = Field(default=0.25, description="speed of the arm")
    gripper_speed: Annotated[Speed, Within(1e-4, 0.5, "Speed")] = 0.15
    depth: Annotated[Length, Within(0.001, 0.1, "Length")] = Field(
        default=0.025, description="depth of the hand past first contact"
    )
    stretch: Span = Span.model_construct(min=0.0, max=0.08)
    force: Annotated[Force, Within(0.1, 200.0, "Force")] = Field(
        default=20.0, description="force on the arm, whether it moves or stands"
    )
    peak_force: Annotated[Force, Within(0.1, 2000.0, "Force")] = Field(
        default=75.0,
        description="largest force that something may feel before a stopped arm stands; `check --cell` warns above it",
    )
    stiffness: Annotated[Stiffness, Within(10.0, 1e7, "Stiffness")] = Field(
        default=20e3,
        description="stiffness of hand and object in contact, for that warning; the membrane alone has 0.6 N/mm, bare fingers on a table some 200",
    )
    contact: ContactLimit | None = None
    unwatched: Annotated[Time, Within(0.1, 60.0, "Time")] = Field(
        default=1.0,
        description="longest time a motion goes on without a tick that looks at it, under the drivers `ur` and `robotiq`: "
        "the twin stands still between ticks",
    )

    @classmethod
    def from_plain(cls, values: Mapping[str, Any]) -> Limits:
        """Return the limits whose `model_dump` these SI values are."""
        made: dict[str, Any] = {
            name: Span.model_construct(**value) if isinstance(value, Mapping) and name != "contact" else value
            for name, value in values.items()
        }
        contact = made.pop("contact", None)
        return cls.model_construct(**made, contact=contact and ContactLimit.model_construct(**contact))

    def span(self, name: str) -> tuple[float, float]:
        """Return the least and the greatest value that a limit allows, SI.

        Beside the fields there are `held_force`, at which a motion stops; `lowered_force`, of a motion that stops at the lower of its
        own limit and the cell's; `travel`, the height of the box; `radius`, of the largest circle that fits into it; and
        `contact_speed`, of the hand where it may meet something.
        """
        if name == "contact_speed":
            return -math.inf, self.speed if self.contact is None else min(self.speed, self.contact.speed)
        if name == "held_force":
            return -math.inf, self.force
        if name == "lowered_force":
            return -math.inf, math.inf
        if name == "travel":
            return -math.inf, self.height.max - self.height.min
        if name == "radius":
            return -math.inf, min(span.max - span.min for span in (self.x, self.y)) / 2
        limit: Span | float = getattr(self, name)
        return (limit.min, limit.max) if isinstance(limit, Span) else (-math.inf, limit)

    def slowed(self, speed: float, heights: Iterable[float]) -> float:
        """Return a speed, m/s, or the lower one that is allowed where a way with these heights, m, may meet something."""
        low = self.contact is not None and any(height < self.contact.below for height in heights)
        return min(speed, self.span("contact_speed")[1]) if low else speed

    def check_pose(self, device: str, target: Pose, hand: Hand) -> None:
        """Raise BeyondLimits when the hand may not go there."""
        for name, span, value in zip("xy", (self.x, self.y), target.position[:2], strict=True):
            _check_span(device, name, span, value, (name, "radius"))
        _check_span(device, "height", self.height, target.height, ("depth", "travel"))
        depth = hand.depth(target.height)
        if depth is not None and (past := _past("depth", depth, self.depth, "Length")):
            raise BeyondLimits(device, past, ("depth",))

    def check_opening(self, device: str, opening: float, hand: Hand) -> None:
        """Raise BeyondLimits when the membrane may not be stretched so."""
        stretch = hand.geometry.stretch(opening)
        _check_span(device, "stretch", self.stretch, stretch, ("stretch",), remedy("stretch"))

    def check_fingers(self, device: str, speed: float) -> None:
        """Raise BeyondLimits above the allowed speed of the fingers, m/s, and InvalidInput when it is no speed."""
        check_speed(device, speed)
        if past := _past("speed", speed, self.gripper_speed, "Speed"):
            raise BeyondLimits(device, past + remedy("gripper_speed"), ("gripper_speed",))

    def check_way(self, device: str, speed: float, heights: Sequence[float]) -> None:
        """Raise BeyondLimits when the hand may not have a speed, m/s, on a way with these heights, m, and InvalidInput when it is no speed."""
        check_speed(device, speed)
        if speed > self.slowed(self.speed, heights) + _ROUNDING:
            raise BeyondLimits(device, self._too_fast("speed", speed, heights), ("speed", "contact_speed"))

    def check_measured(self, device: str, speed: float, heights: Sequence[float]) -> None:
        """Raise LimitExceeded when the hand was faster, m/s, than it may be at these heights, m."""
        if speed > most_measured(self.slowed(self.speed, heights)):
            raise LimitExceeded(device, self._too_fast("measured speed", speed, heights))

    def _too_fast(self, name: str, speed: float, heights: Sequence[float]) -> str:
        most, where = self.slowed(self.speed, heights), ""
        if self.contact is not None and most < self.speed:
            below = format_quantity(self.contact.below, KINDS["Length"])
            where = f" below a height of {below}, where the hand may meet something"
        return f"{past_limit(name, speed, most, 'Speed')}{where}"

    def check_force(self, device: str, force: float) -> None:
        """Raise LimitExceeded when the arm feels too much."""
        if past := _past("force", force, self.force, "Force"):
            raise LimitExceeded(device, past)


def _past(name: str, value: float, most: float, kind: str) -> str:
    """Return the message about a value past its limit, SI; empty where it is not past."""
    return "" if value <= most + _ROUNDING else past_limit(name, value, most, kind)


def _check_span(device: str, name: str, span: Span, value: float, concerns: Sequence[str], then: str = "") -> None:
    if not span.min - _ROUNDING <= value <= span.max + _ROUNDING:
        raise BeyondLimits(device, outside_limits(name, value, span.min, span.max) + then, concerns)
