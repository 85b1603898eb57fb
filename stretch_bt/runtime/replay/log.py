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
        #: device, owner and name of each command, by the tick
        self.commands: dict[int, list[tuple[str, str, str]]] = {}
        for event in reader.events:
            if event["type"] == "command":
                command = (event["device"], event["owner"], event["name"])
                self.commands.setdefault(event["tick"], []).append(command)
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

    def due_fault(self, device: str) -> DeviceFault | None:
        """Return the fault that is next of what the record handed out of a device, without taking it; None for anything else."""
        item = self.peek(device)
        fault: DeviceFault | None = item.value if item is not None and item.kind == "fault" else None
        return fault

    def take_next(self, device: str) -> Any:
        """Take what is next of a device: its value."""
        return self.queues[device].popleft().value

    def moves_after(self, device: str, owner: str) -> bool:
        """Whether a motion of an owner follows what is next of a device in this tick."""
        later = list(self.queues.get(device, ()))[1:]
        return any((item.kind, item.name) == ("motion", owner) for item in later)

    def commanded(self, device: str, owner: str, *names: str) -> bool:
        """Whether an owner gave a device a command in this tick, one of these names where any are given."""
        told = self.commands.get(self.tick, [])
        return any((d, o) == (device, owner) and (not names or name in names) for d, o, name in told)
