"""What the process of a camera is told at its begin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

__all__ = ["Settings"]


@dataclass(frozen=True)
class Settings:
    """Where the frames come from (one of `serial`, `file` and `host`), and what the process goes by; SI."""

    serial: str | None
    file: str | None
    host: str | None
    port: int
    width: int
    height: int
    rate: float
    lost_after: float
    noisy: bool
    record: str | None

    def to_message(self) -> dict[str, Any]:
        """Return the fields for a message."""
        return asdict(self)

    @classmethod
    def from_message(cls, message: Mapping[str, Any]) -> Settings:
        """Return the settings of a message."""
        return cls(**{f.name: message[f.name] for f in fields(cls)})
