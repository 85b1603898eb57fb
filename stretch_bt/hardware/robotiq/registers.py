"""The registers of a 2F gripper, as its manual has them: commands that are written to it, and the status that it reports.

Three registers each way, the first byte of each in its high half. Written from 0x03E8: action, position, speed and force;
read from 0x07D0: status, fault and echo of the position, position and current.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from stretch_bt.errors import InvalidInput

__all__ = [
    "FAULTS",
    "PASSING",
    "READ_FROM",
    "WRITE_TO",
    "ActivationStage",
    "Command",
    "FaultCode",
    "ObjectStatus",
    "Status",
    "fault_of",
]

WRITE_TO, READ_FROM, COUNT = 0x03E8, 0x07D0, 3


class ActivationStage(IntEnum):
    """How far activation is (gSTA)."""

    RESET = 0
    ACTIVATING = 1
    UNUSED = 2
    ACTIVE = 3


class ObjectStatus(IntEnum):
    """What the fingers met (gOBJ); holds only when gGTO is set and the echo is the position that was asked for."""

    MOVING = 0
    WHILE_OPENING = 1
    WHILE_CLOSING = 2
    ARRIVED = 3


class FaultCode(NamedTuple):
    """What a fault code (gFLT) means, what to do, and whether only a reset with a new activation clears it."""

    means: str
    remedy: str
    reset: bool


_ACTIVATE = "reset and activate it with: stretch-bt activate CELL"
FAULTS: dict[int, FaultCode] = {
    0x05: FaultCode("a motion was asked for before the activation was over", "wait for the activation to end", False),
    0x07: FaultCode("a motion was asked for without activation", "activate the gripper", False),
    0x08: FaultCode("it is too hot, 85 °C or more", "let it cool down, then start a new run", False),
    0x09: FaultCode(
        "it heard nothing for a second or more", "check cable and load of the bus, then start a new run", False
    ),
    0x0A: FaultCode("its supply voltage is too low", f"check the 24 V supply, then {_ACTIVATE}", True),
    0x0B: FaultCode("an automatic release is under way", f"wait until the fingers stand, then {_ACTIVATE}", True),
    0x0C: FaultCode("an internal fault", f"{_ACTIVATE}; if it comes again, the gripper needs service", True),
    0x0D: FaultCode("the activation failed", f"take away what is in the way of the fingers, then {_ACTIVATE}", True),
    0x0E: FaultCode("too much current", f"take the load off the fingers, then {_ACTIVATE}", True),
    0x0F: FaultCode("an automatic release was made", f"find out who asked for it, then {_ACTIVATE}", True),
}


#: faults that the next command clears
PASSING = (0x05, 0x07, 0x09)


def fault_of(code: int) -> FaultCode:
    """Return what a fault code means; one that the manual does not list needs a reset too."""
    return FAULTS.get(code, FaultCode("a fault that the manual does not list", _ACTIVATE, True))


@dataclass(frozen=True, slots=True)
class Status:
    """Status that the gripper reports: bits and counts of one exchange."""

    activated: bool
    going: bool
    stage: ActivationStage
    found: ObjectStatus
    fault: int
    echo: int
    position: int
    current: int = 0

    @classmethod
    def decode(cls, registers: Sequence[int]) -> Status:
        """Return the status in three registers; raises InvalidInput when there are not three words."""
        if len(registers) != COUNT or not all(isinstance(r, int) and 0 <= r <= 0xFFFF for r in registers):
            raise InvalidInput(
                f"its status is {len(registers)} registers, {list(registers)[:8]}, and a 2F gripper has {COUNT}"
            )
        bits, fault, place = registers
        action = bits >> 8
        return cls(
            activated=bool(action & 1),
            going=bool(action >> 3 & 1),
            stage=ActivationStage(action >> 4 & 3),
            found=ObjectStatus(action >> 6),
            fault=fault >> 8 & 0x0F,  # the high half of the byte belongs to an optional controller
            echo=fault & 0xFF,
            position=place >> 8,
            current=place & 0xFF,
        )

    def encode(self) -> list[int]:
        """Return the three registers."""
        action = self.activated | self.going << 3 | self.stage << 4 | self.found << 6
        return [action << 8, self.fault << 8 | self.echo, self.position << 8 | self.current]

    @property
    def ready(self) -> bool:
        """Whether it takes motions."""
        return self.activated and self.stage is ActivationStage.ACTIVE


@dataclass(frozen=True, slots=True)
class Command:
    """What is asked of the gripper; counts from 0 to 255. A release is its slow way out of an emergency, which closes or opens it."""

    activate: bool
    go: bool = False
    position: int = 0
    speed: int = 0
    force: int = 0
    release: bool = False
    release_opens: bool = False

    def encode(self) -> list[int]:
        """Return the three registers; raises InvalidInput for a count out of range."""
        for name in ("position", "speed", "force"):
            if not 0 <= getattr(self, name) <= 0xFF:
                raise InvalidInput(f"{name} is a count from 0 to 255, not {getattr(self, name)}")
        action = self.activate | self.go << 3 | self.release << 4 | self.release_opens << 5
        return [action << 8, self.position, self.speed << 8 | self.force]

    @classmethod
    def decode(cls, registers: Sequence[int]) -> Command:
        """Return the command in three registers."""
        action = registers[0] >> 8
        return cls(
            activate=bool(action & 1),
            go=bool(action >> 3 & 1),
            release=bool(action >> 4 & 1),
            release_opens=bool(action >> 5 & 1),
            position=registers[1] & 0xFF,
            speed=registers[2] >> 8,
            force=registers[2] & 0xFF,
        )
