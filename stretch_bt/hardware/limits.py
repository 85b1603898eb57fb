"""The limits of a cell, checked before a command is sent and while the arm moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from stretch_bt.errors import InvalidInput, LimitExceeded
from stretch_bt.frames import Pose
from stretch_bt.hardware.hand import Hand
from stretch_bt.units import KINDS, Force, Length, Speed, Time, Within, format_quantity

__all__ = ["Limits", "Span"]

_Place = Annotated[Length, Within(-10.0, 10.0, "Length")]
_ROUNDING = 1e-9
_M = TypeVar("_M", bound=BaseModel)


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


class Limits(_Model):
    """What no command may ask for, and the force at which the arm is stopped; heights are world z of the hand."""

    x: Span = Span.model_construct(min=-0.5, max=0.5)
    y: Span = Span.model_construct(min=-0.5, max=0.5)
    height: Span = Span.model_construct(min=0.0, max=0.6)
    speed: Annotated[Speed, Within(1e-4, 1.5, "Speed")] = Field(default=0.25, description="of the arm")
    gripper_speed: Annotated[Speed, Within(1e-4, 0.5, "Speed")] = 0.15
    depth: Annotated[Length, Within(0.001, 0.1, "Length")] = Field(default=0.025, description="hand past first contact")
    stretch: Span = Span.model_construct(min=0.0, max=0.08)
    force: Annotated[Force, Within(0.1, 200.0, "Force")] = Field(
        default=20.0, description="on the arm, whether it moves or stands"
    )
    unwatched: Annotated[Time, Within(0.1, 60.0, "Time")] = Field(
        default=1.0, description="a motion goes on that no tick looks at"
    )

    def span(self, name: str) -> tuple[float, float]:
        """Return the least and the greatest value that a limit allows, SI.

        Beside the fields there are `travel`, the height of the box, and `radius`, of the largest circle that fits into it.
        """
        if name == "travel":
            return -math.inf, self.height.max - self.height.min
        if name == "radius":
            return -math.inf, min(span.max - span.min for span in (self.x, self.y)) / 2
        limit: Span | float = getattr(self, name)
        return (limit.min, limit.max) if isinstance(limit, Span) else (-math.inf, limit)

    @classmethod
    def restored(cls, plain: Mapping[str, Any]) -> Limits:
        """Return the limits whose `model_dump` a record has; fields that it has not keep their defaults."""
        return _restored(cls, plain)

    def check_pose(self, device: str, target: Pose, hand: Hand) -> None:
        """Raise LimitExceeded when the hand may not go there."""
        for name, span, value in zip("xy", (self.x, self.y), target.position[:2], strict=True):
            _check_span(device, name, span, value)
        _check_span(device, "height", self.height, target.height)
        depth = hand.depth(target.height)
        if depth is not None:
            _check(device, "depth", depth, self.depth, "Length")

    def check_opening(self, device: str, opening: float, hand: Hand) -> None:
        """Raise LimitExceeded when the membrane may not be stretched so."""
        _check_span(device, "stretch", self.stretch, hand.geometry.stretch(opening))

    def check_speed(self, device: str, speed: float, most: float) -> None:
        """Raise LimitExceeded above the allowed speed, and InvalidInput when it is no speed."""
        if not (math.isfinite(speed) and speed > 0):
            raise InvalidInput(f"{device}: speed must be finite and above 0 m/s, not {speed}")
        _check(device, "speed", speed, most, "Speed")

    def check_force(self, device: str, force: float) -> None:
        """Raise LimitExceeded when the arm feels too much."""
        _check(device, "force", force, self.force, "Force")


def _restored(model: type[_M], plain: Mapping[str, Any]) -> _M:
    """Return a model of numbers in SI, which need no check and have no unit."""
    kinds = {
        name: field.annotation for name, field in model.model_fields.items() if isinstance(plain.get(name), Mapping)
    }
    parts = {name: _restored(kind, plain[name]) for name, kind in kinds.items() if isinstance(kind, type)}
    return model.model_construct(**{**plain, **parts})


def _check(device: str, name: str, value: float, most: float, kind: str) -> None:
    if not value <= most + _ROUNDING:
        asked, allowed = (format_quantity(v, KINDS[kind]) for v in (value, most))
        raise LimitExceeded(device, f"{name} {asked} is past the limit of the cell, at most {allowed}")


def _check_span(device: str, name: str, span: Span, value: float) -> None:
    if not span.min - _ROUNDING <= value <= span.max + _ROUNDING:
        asked, least, most = (format_quantity(v, KINDS["Length"]) for v in (value, span.min, span.max))
        raise LimitExceeded(device, f"{name} {asked} is past the limits of the cell, {least} to {most}")
