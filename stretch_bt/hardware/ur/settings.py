"""What the process of an arm is told at its begin, and what it tells of the arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

__all__ = ["ArmState", "Settings"]

_ZERO6 = (0.0,) * 6


@dataclass(frozen=True)
class Settings:
    """Everything that the process goes by; SI, transforms as position and rotation vector."""

    host: str
    model: str
    #: robot's base in the world, and hand at the flange
    base: tuple[float, ...]
    hand: tuple[float, ...]
    rate: float
    acceleration: float
    stop_acceleration: float
    lookahead: float
    gain: float
    watchdog: float
    upper_registers: bool
    payload: tuple[float, ...] | None
    lost_after: float
    heartbeat: float
    tolerance: float
    contact_force: float | None
    #: spans of the hand in the world, and of the cell's other limits
    x: tuple[float, float]
    y: tuple[float, float]
    height: tuple[float, float]
    speed: float
    depth: float
    force: float
    #: how long a motion goes on that no tick looks at, s
    unwatched: float

    def to_message(self) -> dict[str, Any]:
        """Return the fields for a message."""
        return asdict(self)

    @classmethod
    def from_message(cls, message: Mapping[str, Any]) -> Settings:
        """Return the settings of a message."""
        known = {f.name for f in fields(cls)}
        plain: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in message.items() if k in known}
        return cls(**plain)


@dataclass(frozen=True)
class ArmState:
    """How the arm stands in one cycle.

    Poses are those of the hand in the robot's base, as position, m, and rotation vector, rad; the wrench is in base axes.
    """

    #: the controller's time, s, and the number of the cycle
    time: float
    number: int
    q: tuple[float, ...]
    pose: tuple[float, ...]
    speed: tuple[float, ...]
    wrench: tuple[float, ...]
    #: the motion that was begun last, by its number, and how it stands
    motion: int = 0
    motion_state: str = "done"
    #: why the arm takes no motion, if it takes none
    fault: str | None = None
    engaged: bool = False

    def to_message(self) -> dict[str, Any]:
        """Return the fields for a message."""
        return {"say": "state", **asdict(self)}

    @classmethod
    def from_message(cls, message: Mapping[str, Any]) -> ArmState:
        """Return the state of a message; raises TypeError or KeyError for another one."""
        sixes: dict[str, Any] = {
            name: tuple(float(v) for v in message[name]) for name in ("q", "pose", "speed", "wrench")
        }
        rest: dict[str, Any] = {f.name: message[f.name] for f in fields(cls) if f.name not in sixes}
        return cls(**rest, **sixes)
