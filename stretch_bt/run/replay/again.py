"""Ticking a recorded tree again, and comparing what it decided."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from stretch_bt.errors import Diagnostic, RecordError, StretchError
from stretch_bt.hardware.hand import Hand, HandGeometry
from stretch_bt.hardware.limits import Limits
from stretch_bt.run.clock import ReplayClock
from stretch_bt.run.mocks import read_mocks
from stretch_bt.run.record import RecordReader, RunRecord
from stretch_bt.run.replay.devices import ReplayedCell
from stretch_bt.run.replay.log import Log
from stretch_bt.run.runner import Runner
from stretch_bt.run.task import Task
from stretch_bt.threads import one_thread
from stretch_bt.tree.modules import Modules
from stretch_bt.tree.program import load_program

__all__ = ["ReplayResult", "replay"]

#: events that are decisions of the tree
DECISIONS = ("status", "command", "write")
#: events of the machine's pace, which a replay does not share
LATE = "overrun"


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """Whether a replay decided alike; the fields of `replay --json`."""

    identical: bool
    decisions: int
    first_difference: dict[str, Any] | None

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `replay --json` prints."""
        return asdict(self)


def replay(record: str | Path, *, trust: bool = False) -> ReplayResult:
    """Tick the recorded tree again on the recorded readings.

    A record says where its tree stood. Python modules that stood beside it are executed only with `trust`; those
    that are installed always.

    Raises
    ------
    RecordError
        The folder holds no record that can be replayed.
    """
    reader = RecordReader(Path(record))
    if not reader.run_info.get("sources"):
        raise _damaged(record, "run.json is missing or incomplete")
    with tempfile.TemporaryDirectory(prefix="stretch-replay-") as folder:
        again = Path(folder).resolve()
        try:
            task = _prepare(reader.run_info, again, trust)
            with one_thread():  # as it was run: the last digits depend on it
                _run_again(reader, task, again)
            return _compare(reader, RecordReader(again / "record"))
        except (LookupError, TypeError, AttributeError, ValueError) as error:
            if isinstance(error, StretchError):
                raise
            raise _damaged(record, f"it cannot be read: {type(error).__name__}: {error}") from error


def _damaged(record: str | Path, message: str) -> RecordError:
    return RecordError([Diagnostic(str(record), 1, 1, "error", "record-damaged", message, "record the run again")])


def _run_again(reader: RecordReader, task: Task, folder: Path) -> None:
    info = reader.run_info
    log = Log(reader)
    written = RunRecord(folder / "record")
    written.start(reader.header, {"sources": {}})
    declared = task.program.document.devices
    cell = ReplayedCell({name: declared[name].interface.__name__ for name in task.devices()}, log, written)
    task.context.devices = cell.devices
    task.context.about, task.context.folder, task.context.repeated = reader.header, written.folder, reader.folder
    if info.get("hand"):
        task.context.hand = Hand(HandGeometry(**info["hand"]))
    if info.get("limits"):  # nodes that go no further than the cell allows
        task.context.limits = Limits.from_plain(info["limits"])
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


def _prepare(info: Mapping[str, Any], folder: Path, trust: bool) -> Task:
    """Write the recorded files out again and build the tree from them; writes nothing outside `folder`."""
    home = folder / "a" / "b" / "c"  # deep enough for imports that go up
    home.mkdir(parents=True)
    names = list(info["sources"])
    for name, text in info["sources"].items():
        _write_source(name, text, home, folder)
    mocks = None
    if info.get("mocks"):
        (home / "mocks.yaml").write_text(info["mocks"], encoding="utf-8")
        mocks = read_mocks(home / "mocks.yaml")
    program = load_program(home / names[0], info.get("set") or {}, _modules(info, home, trust)).require()
    return Task(program, info.get("set") or {}, info.get("seed", 0), info.get("scene"), info.get("cell"), mocks)


def _modules(info: Mapping[str, Any], home: Path, trust: bool) -> Modules:
    """Return where modules may stand: never in `home`, which the record fills."""
    origin = Path(info["tree"]).parent
    hint = f"add --trust to execute the modules in {origin}, if you know what they do; or install the package"
    return Modules(home, origin if trust else None, hint)


def _write_source(name: str, text: str, home: Path, folder: Path) -> None:
    """Write one recorded file; one that was imported from a fixed place has to be there as it was."""
    path = (home / name).resolve()
    if path.is_relative_to(folder):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    elif not path.is_file() or path.read_text("utf-8") != text:
        raise _damaged(path, "the file was imported from here and is gone, or has changed since")


def _interrupts(events: Sequence[Mapping[str, Any]]) -> dict[int, list[str]]:
    """Return after which tick the record was interrupted, and by what."""
    found: dict[int, list[str]] = {}
    for event in events:
        if event["type"] == "interrupt":
            found.setdefault(max(event["tick"], 0) + 1, []).extend(event["why"])
    return found


def _compare(recorded: RecordReader, replayed: RecordReader) -> ReplayResult:
    decisions = sum(event["type"] in DECISIONS for event in recorded.events)
    before, after = ([e for e in r.events if e["type"] != LATE] for r in (recorded, replayed))
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
