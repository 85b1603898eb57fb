"""What a record handed out, tick by tick and device by device."""

from __future__ import annotations

from collections import deque
from typing import Any

from stretch_bt.break_off import BrokenOff
from stretch_bt.errors import DeviceFault, StretchError
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.record import RecordReader

__all__ = ["Diverged", "Log"]


class Diverged(StretchError):
    """The tree asks for something that the record does not hold."""


class Log(Onlooker):
    """What the record handed out in the present tick, device by device; also a watcher, to know the tick."""

    def __init__(self, reader: RecordReader) -> None:
        self.reader = reader
        self.queues: dict[str, deque[Any]] = {}
        self.commands: dict[int, list[tuple[str, str]]] = {}
        for event in reader.events:
            if event["type"] == "command":
                self.commands.setdefault(event["tick"], []).append((event["device"], event["owner"]))
        self.broken_off = {event["tick"] for event in reader.events if event.get("broken_off") or event.get("cut_off")}
        self.tick = -1
        self.begin_tick(-1, 0.0)

    def begin_tick(self, tick: int, time: float) -> None:
        """Take up what the record holds for this tick."""
        self.tick = tick
        self.queues = {}
        for item in self.reader.handed(tick):
            self.queues.setdefault(item.device, deque()).append(item)

    def next(self, device: str, kind: str, name: str) -> Any:
        """Return the next value that the record handed out; raises a recorded fault or NoAnswer, BrokenOff as the record was, or Diverged."""
        queue = self.queues.get(device)
        item = queue.popleft() if queue else None
        if item is not None and item.kind in ("fault", "unanswered"):
            raise item.value
        if item is None and self.tick in self.broken_off:
            raise BrokenOff
        if item is None or (item.kind, item.name) != (kind, name):
            found = f"{item.kind} {item.name}" if item is not None else "nothing"
            raise Diverged(f"{device}: the tree asks for {kind} {name} and the record holds {found}")
        return item.value

    def peek(self, device: str) -> Any:
        """Return the next item of a device without taking it, or None."""
        queue = self.queues.get(device)
        return queue[0] if queue else None

    def refused(self, device: str, owner: str) -> DeviceFault | None:
        """Return the fault with which the record refused a command, or None when it took it."""
        item = self.peek(device)
        taken = (device, owner) in self.commands.get(self.tick, [])
        if item is None or item.kind != "fault" or taken:
            return None
        fault: DeviceFault = self.queues[device].popleft().value
        return fault
