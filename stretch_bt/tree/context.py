"""What a node may know of the run it is in."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.limits import Limits

__all__ = ["Context"]


class Context(Protocol):
    """The run, as a node sees it; `now` stays the same during a tick, so that a replay decides alike."""

    now: float
    ticks: int
    period: float  # of the ticks, s
    hand: Hand
    limits: Limits | None  # of the cell, where the run has one
    devices: Mapping[str, Any]  # by their names in the tree; none before they are open, and where all is mocked
    memory: dict[Any, Any]  # what the nodes of one run remember together
    about: Mapping[str, Any]  # what identifies the run: the header of its record
    folder: Path | None  # of the run's record, where it has one
    repeated: Path | None  # in a replay, the record that is replayed: files outside a record are then left alone

    @property
    def time(self) -> float:
        """Time since the run began, s."""
        ...

    @property
    def slot(self) -> int:
        """Place of this tick on the grid of the run's ticks: times that nodes wait for are counted in it."""
        ...

    def device(self, name: str) -> Any:
        """Return a device that the tree declared; raises NotReady when the run has none."""
        ...

    def reading(self, device: str, name: str) -> Any:
        """Return a reading of a device for an expression, such as `arm.force`."""
        ...
