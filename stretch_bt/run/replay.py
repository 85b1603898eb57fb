"""Replay: the same tree ticked again on the readings of a record, and the first decision that differs.

The replayed devices hand out what the record holds, tick by tick and in order; everything else, perception included, is
computed anew and written as a record of its own, whose events are compared with the recorded ones.
"""

from __future__ import annotations

import tempfile
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from stretch_bt.errors import DeviceFault, Diagnostic, RecordError, StretchError
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.hand import Hand, HandGeometry
from stretch_bt.hardware.interfaces import Motion, MotionState, Reading
from stretch_bt.hardware.journal import Journal
from stretch_bt.run.clock import ReplayClock
from stretch_bt.run.mocks import read_mocks
from stretch_bt.run.record import RecordReader, RunRecord
from stretch_bt.run.runner import Runner
from stretch_bt.run.task import Task
from stretch_bt.tree.program import load_program

__all__ = ["ReplayResult", "replay"]

#: events that are decisions of the tree
DECISIONS = ("status", "command", "write")


class Diverged(StretchError):
    """The tree asks for something that the record does not hold."""


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """Whether a replay decided alike; the fields of `replay --json`."""

    identical: bool
    decisions: int
    first_difference: dict[str, Any] | None

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `replay --json` prints."""
        return asdict(self)


def replay(record: str | Path) -> ReplayResult:
    """Tick the recorded tree again on the recorded readings.

    Raises
    ------
    RecordError
        The folder holds no record that can be replayed.
    """
    reader = RecordReader(Path(record))
    if "sources" not in reader.run_info:
        raise RecordError(
            [
                Diagnostic(
                    str(record),
                    1,
                    1,
                    "error",
                    "record-damaged",
                    "run.json is missing or incomplete",
                    "record the run again",
                )
            ]
        )
    with tempfile.TemporaryDirectory(prefix="stretch-replay-") as folder:
        again = Path(folder)
        _run_again(reader, again)
        return _compare(reader, RecordReader(again / "record"))


def _run_again(reader: RecordReader, folder: Path) -> None:
    info = reader.run_info
    task = _prepare(info, folder)
    log = _Log(reader)
    written = RunRecord(folder / "record")
    written.start(reader.header, {"sources": {}})
    cell = _ReplayedCell(task, log, written)
    task.context.devices = cell.devices
    if info.get("hand"):
        task.context.hand = Hand(HandGeometry(**info["hand"]))
    clock = ReplayClock([time for _, time in reader.ticks])
    runner = Runner(
        task.built,
        task.context,
        clock,
        period=task.program.document.tick_period,
        cell=cell,
        watchers=[log, written],
        interrupts=_interrupts(reader.events),
    )
    outcome = runner.run()
    written.close(asdict(outcome))


def _prepare(info: Mapping[str, Any], folder: Path) -> Task:
    """Write the recorded files out again, deep enough for imports that go up, and build the tree from them."""
    home = folder / "a" / "b" / "c"
    names = list(info["sources"])
    for name, text in info["sources"].items():
        path = home / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    mocks = None
    if info.get("mocks"):
        (home / "mocks.yaml").write_text(info["mocks"], encoding="utf-8")
        mocks = read_mocks(home / "mocks.yaml")
    program = load_program(home / names[0], info.get("set") or {}).require()
    return Task(program, info.get("set") or {}, info.get("seed", 0), info.get("scene"), info.get("cell"), mocks)


def _interrupts(events: Sequence[Mapping[str, Any]]) -> dict[int, list[str]]:
    """Return after which tick the record was interrupted, and by what."""
    found: dict[int, list[str]] = {}
    for event in events:
        if event["type"] == "interrupt":
            found.setdefault(max(event["tick"], 0) + 1, []).extend(event["why"])
    return found


def _compare(recorded: RecordReader, replayed: RecordReader) -> ReplayResult:
    decisions = sum(event["type"] in DECISIONS for event in recorded.events)
    before, after = list(recorded.events), list(replayed.events)
    if not recorded.complete:
        after = after[: len(before)]
    for old, new in zip(before, after, strict=False):
        if old != new:
            return ReplayResult(False, decisions, _difference(old, new))
    if len(before) != len(after):
        longer = before if len(before) > len(after) else after
        extra = longer[min(len(before), len(after))]
        return ReplayResult(False, decisions, _difference(*((extra, None) if longer is before else (None, extra))))
    return ReplayResult(True, decisions, None)


def _difference(old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> dict[str, Any]:
    event = old or new or {}
    node = event.get("path") or event.get("owner") or event.get("device") or event.get("type", "")
    return {"tick": event.get("tick"), "node": node, "recorded": old, "replayed": new}


class _Log:
    """What the record handed out in the present tick, device by device; also a watcher, to know the tick."""

    def __init__(self, reader: RecordReader) -> None:
        self.reader = reader
        self.queues: dict[str, deque[Any]] = {}
        self.commands: dict[int, list[tuple[str, str]]] = {}
        for event in reader.events:
            if event["type"] == "command":
                self.commands.setdefault(event["tick"], []).append((event["device"], event["owner"]))
        self.tick = -1
        self.begin_tick(-1, 0.0)

    def begin_tick(self, tick: int, time: float) -> None:
        """Take up what the record holds for this tick."""
        self.tick = tick
        self.queues = {}
        for item in self.reader.handed(tick):
            self.queues.setdefault(item.device, deque()).append(item)

    def status(self, path: str, status: str, reason: str = "") -> None:
        """Nothing to do."""

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Nothing to do."""

    def note(self, kind: str, **fields: Any) -> None:
        """Nothing to do."""

    def next(self, device: str, kind: str, name: str) -> Any:
        """Return the next value that the record handed out; raises a recorded fault, or Diverged."""
        queue = self.queues.get(device)
        item = queue.popleft() if queue else None
        if item is not None and item.kind == "fault":
            raise item.value
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


class _ReplayedMotion:
    """A motion whose states come from the record."""

    def __init__(self, device: _ReplayedDevice, owner: str) -> None:
        self.owner = owner
        self.device = device
        self.ended = False

    def poll(self) -> MotionState:
        """Return the recorded state."""
        state: MotionState = self.device.take("motion", self.owner)
        self.device.journal.motion(self.device.name, self.owner, state)
        self.ended = self.ended or state is not MotionState.MOVING
        return state

    def stop(self) -> None:
        """Note the stop when the motion still has the device."""
        if not self.ended:
            self.ended = True
            self.device.journal.command(self.device.name, "stop", {}, self.owner)


class _ReplayedDevice:
    """Any device: readings and motions by name, commands noted."""

    def __init__(self, name: str, log: _Log, journal: Journal) -> None:
        self.name = name
        self.log = log
        self.journal = journal
        self.current: _ReplayedMotion | None = None

    def take(self, kind: str, name: str) -> Any:
        """Return the next recorded value, or raise the recorded fault."""
        try:
            return self.log.next(self.name, kind, name)
        except DeviceFault as fault:
            self.journal.fault(self.name, fault)
            raise

    def read(self, name: str) -> Reading[Any]:
        """Return the next recorded reading."""
        reading: Reading[Any] = self.take("reading", name)
        self.journal.reading(self.name, name, reading)
        return reading

    def command(self, name: str, arguments: Mapping[str, Any], owner: str) -> Motion:
        """Note a command and return its motion, or raise the fault with which it was refused."""
        fault = self.log.refused(self.name, owner)
        if fault is not None:
            self.journal.fault(self.name, fault)
            raise fault
        self.stop()
        self.journal.command(self.name, name, arguments, owner)
        self.current = _ReplayedMotion(self, owner)
        return self.current

    def stop(self) -> None:
        """End the present motion without a word, as a device that is stopped or taken over."""
        if self.current is not None:
            self.current.ended = True


class _ReplayedArm(_ReplayedDevice):
    def move(self, target: Pose, *, speed: float, owner: str) -> Motion:
        return self.command("move", {"target": target, "speed": speed}, owner)

    def follow(self, path: Sequence[Pose], *, speed: float, owner: str) -> Motion:
        return self.command("follow", {"path": list(path), "speed": speed}, owner)

    def pose(self, max_age: float) -> Reading[Pose]:
        return self.read("pose")

    def wrench(self, max_age: float) -> Reading[Wrench]:
        return self.read("wrench")


class _ReplayedGripper(_ReplayedDevice):
    def move(self, opening: float, *, speed: float, owner: str) -> Motion:
        return self.command("move", {"opening": opening, "speed": speed}, owner)

    def opening(self, max_age: float) -> Reading[float]:
        return self.read("opening")


class _ReplayedCamera(_ReplayedDevice):
    intrinsics: Intrinsics

    def frame(self, max_age: float) -> Reading[DepthFrame]:
        return self.read("frame")

    @property
    def ended(self) -> bool:
        item = self.log.peek(self.name)
        return item is not None and item.name == "ended" and bool(self.read("ended").value)


class _ReplayedForceSensor(_ReplayedDevice):
    def wrench(self, max_age: float) -> Reading[Wrench]:
        return self.read("wrench")

    def zero(self) -> None:
        self.journal.command(self.name, "zero", {}, "")


_REPLAYED: dict[str, type[_ReplayedDevice]] = {
    "Arm": _ReplayedArm,
    "Gripper": _ReplayedGripper,
    "DepthCamera": _ReplayedCamera,
    "ForceSensor": _ReplayedForceSensor,
}


class _ReplayedCell:
    """The devices of a record."""

    def __init__(self, task: Task, log: _Log, journal: Journal) -> None:
        declared = task.program.document.devices
        self.devices = {
            name: _REPLAYED[declared[name].interface.__name__](name, log, journal) for name in sorted(task.devices())
        }

    def stop(self) -> list[Exception]:
        """End every motion."""
        for device in self.devices.values():
            device.stop()
        return []
