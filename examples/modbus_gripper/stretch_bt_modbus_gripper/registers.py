"""The registers of the gripper, as its manual has them: all holding registers of unit 1."""

from __future__ import annotations

from dataclasses import dataclass

#: written: target, 0.01 mm; speed, 0.1 mm/s; command
TARGET, SPEED, COMMAND = 0, 1, 2
GO, HOLD = 1, 2
#: read: opening, 0.01 mm, and state
OPENING, STATE = 10, 11
MOVING, ARRIVED, BLOCKED, HELD = 1, 2, 3, 4

#: of one count, m and m/s
COUNT, SPEED_COUNT = 1e-5, 1e-4
#: all that is read or written lies below
REGISTERS = 16


@dataclass(frozen=True)
class Status:
    """The status that the gripper sends: its opening, m, and its state."""

    opening: float
    state: int
