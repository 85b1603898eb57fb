"""Ticking a recorded tree again, and comparing what it decided."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from stretch_bt import errors
from stretch_bt.clock import ReplayClock
from stretch_bt.errors import Diagnostic, FileError, InvalidInput, RecordError
from stretch_bt.hardware.hand import Hand, HandGeometry
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.own_modules import Modules
from stretch_bt.runtime.mock_arrays import ARRAYS, MockArrays
from stretch_bt.runtime.mocks_file import read_mocks
from stretch_bt.runtime.outcome import Outcome
from stretch_bt.runtime.prepare import VERSIONS, versions
from stretch_bt.runtime.provenance import others
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.record.folder import RUN, damaged, readable, refuse
from stretch_bt.runtime.record.places import Places, usual_folders
from stretch_bt.runtime.replay.behaviours import repeat_behaviours
from stretch_bt.runtime.replay.compare import compare
from stretch_bt.runtime.replay.devices import ReplayedCell
from stretch_bt.runtime.replay.log import Log
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.task import Task
from stretch_bt.runtime.ticker import Planned
from stretch_bt.threads import one_thread
from stretch_bt.tree.program import load_program

__all__ = ["ReplayResult", "replay"]

#: events that are decisions of the tree
DECISIONS = ("status", "command", "write")
#: name of the folders above a tree that is written out again, and how many there are at most
ABOVE, MOST_UP = "above-the-tree", 100
#: events of the machine's pace, which a replay does not share
LATE = "overrun"


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """Whether a replay decided alike; the fields of `replay --json`.

    Attributes
    ----------
    identical : bool
        Every event is as recorded, to the last digit.
    same : bool
        Every status, command and motion is as recorded, and every number within 1e-6 of itself or 1e-3 of its deviation.
    decisions : int
        How many status changes, commands and writes the record holds.
    largest_difference : float
        The largest difference of a number, relative to the number or to 1000 of its standard deviations.
    first_difference : dict or None
        The first event that is not the same, or else the first that is not identical: tick, node, recorded, replayed.
    until : float or None
        Run time, s, up to which a record is whole that was not closed.
    damage : str or None
        Where the recorded log is not as it was written, if it differs.
    others : list of str
        What the replay ran that is not what was recorded: modules of nodes, versions.
    """

    identical: bool
    same: bool
    decisions: int
    largest_difference: float
    first_difference: dict[str, Any] | None
    until: float | None = None
    damage: str | None = None
    others: list[str] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `replay --json` prints."""
        return asdict(self)


def replay(record: str | Path, *, trust: bool = False, say: Callable[[str], None] | None = None) -> ReplayResult:
    """Tick the recorded tree again on the recorded readings.

    A record says where its tree stood. Python modules that stood beside it are executed only with `trust`; those
    that are installed always. `say` receives the path of each file beside the tree before it is executed.

    Raises
    ------
    RecordError
        The folder holds no record that can be replayed.
    KeyboardInterrupt
        A signal came before it was compared.
    """
    reader = RecordReader(Path(record), changed_log=True)
    if reader.run_info.get("calls"):
        what = "it is of calls from Python, which have no tree to tick again"
        raise refuse(
            reader.folder,
            "record-calls",
            what,
            "look at it by `stretch-bt report`; put what should be replayed in a tree file",
        )
    if not reader.has_readings:
        what = "it holds the events alone, and a replay needs what the devices read"
        raise refuse(reader.folder, "record-readings", what, "record the run again with --record full")
    if not reader.run_info.get("sources"):
        raise damaged(reader.folder / RUN, "it holds no text of a tree")
    with readable(reader.folder):
        _check_heard(reader)
    with tempfile.TemporaryDirectory(prefix="stretch-replay-") as folder, readable(reader.folder):
        again = Path(folder).resolve()
        with _in_record(again, reader.folder / RUN):
            task = _prepare(reader, again, trust, say)
        with one_thread():  # as it was run: the last digits depend on it
            _run_again(reader, task, again)
        changed = others(reader.run_info, task.program, versions(*VERSIONS))
        return _compare(reader, RecordReader(again / "record"), changed)


def _check_heard(reader: RecordReader) -> None:
    """Refuse a record that lacks the readings of a device."""
    silent = reader.run_info.get("silent_devices") or []
    if silent:
        what = f"readings of {', '.join(silent)} are not in this record: the caller gave a device that reports to no journal"
        hint = "write a driver for it and open it in a cell, or give it 'tell(name, journal)' as a scripted device has; record it again"
        raise refuse(reader.folder / RUN, "record-incomplete", what, hint)


@contextmanager
def _in_record(folder: Path, record: Path) -> Iterator[None]:
    """Name the file of a record that holds the text, where a file is wrong that was written out of it into a folder."""
    try:
        yield
    except FileError as error:
        # names that are unknown without a module that may not be executed are not reported, only the module is
        refused = [finding for finding in error.diagnostics if finding.code == "import"] or error.diagnostics
        raise RecordError([_moved(finding, folder, record) for finding in refused]) from error


def _moved(finding: Diagnostic, folder: Path, record: Path) -> Diagnostic:
    file = Path(finding.file)
    if not file.is_relative_to(folder):
        return finding
    place = f"in its text of {file.name}, line {finding.line}: "
    return replace(finding, file=str(record), line=1, column=1, message=place + finding.message, length=1)


def _run_again(reader: RecordReader, task: Task, folder: Path) -> None:
    """Tick the task on what the record hands out, into a record of its own."""
    written = RunRecord(folder / "record")
    task.context.about, task.context.folder, task.context.repeated = reader.header, written.folder, reader.folder
    _know_cell(task, reader.run_info)
    folders = [str(folder), str(Path(str(reader.run_info.get("tree") or "")).parent), *usual_folders()]
    written.start(reader.header, {}, Places(folders=folders))
    try:
        written.close(asdict(_tick_again(reader, task, written)))
    finally:
        written.close({})


def _know_cell(task: Task, info: Mapping[str, Any]) -> None:
    """Let nodes know the hand and the limits of the recorded cell."""
    if info.get("hand"):
        task.context.hand = Hand(HandGeometry(**info["hand"]))
    if info.get("limits"):  # nodes that go no further than the cell allows
        task.context.limits = Limits.from_plain(info["limits"])


def _tick_again(reader: RecordReader, task: Task, written: RunRecord) -> Outcome:
    log, document = Log(reader), task.program.document
    repeat_behaviours(task.built, reader)
    kinds = {name: document.devices[name].interface.__name__ for name in task.devices()}
    cell = ReplayedCell(kinds, log, written)
    task.context.devices = cell.devices
    runner = Runner(
        task.built,
        task.context,
        ReplayClock([time for _, time in reader.ticks]),
        period=document.tick_period,
        cell=cell,
        watchers=[log, written],
        max_ticks=task.most_ticks(),
        longest=reader.run_info.get("longest") or math.inf,
        interrupts=_interrupts(reader.events),
        cuts={event["tick"]: event["cut_off"] for event in reader.events if event.get("cut_off")},
    )
    outcome = runner.run()
    if runner.ticker.heard:  # the replay was interrupted, not what it repeats
        raise KeyboardInterrupt(runner.ticker.heard[0])
    return outcome


def _prepare(reader: RecordReader, folder: Path, trust: bool, say: Callable[[str], None] | None) -> Task:
    """Write the recorded files out again and build the tree from them; writes nothing outside `folder`."""
    info = reader.run_info
    names = list(info["sources"])
    home = folder.joinpath(*[ABOVE] * _most_up(names))
    home.mkdir(parents=True)
    for name, text in info["sources"].items():
        _write_source(name, text, home, folder)
    mocks = None
    if info.get("mocks"):
        path = folder / "mocks.yaml"  # above all that the sources may be called
        path.write_text(info["mocks"], encoding="utf-8")
        mocks = read_mocks(path, recorded=True, arrays=_arrays(reader.folder, home))
    program = load_program(home / names[0], info.get("set") or {}, _modules(info, home, trust, say)).require()
    return Task(program, info.get("set") or {}, info.get("seed", 0), info.get("scene"), info.get("cell"), mocks)


def _most_up(names: Sequence[str]) -> int:
    """Return how many folders a relative import goes up at most, within reason."""
    ups = (Path(name).parts.count("..") for name in names if not Path(name).is_absolute())
    return min(max(ups, default=0) + 1, MOST_UP)


def _arrays(record: Path, home: Path) -> MockArrays:
    """Return the arrays that the mocks of a record name."""
    try:
        return MockArrays.of_record(record, home)
    except (OSError, InvalidInput) as error:
        raise damaged(record / ARRAYS, str(error)) from error


def _modules(info: Mapping[str, Any], home: Path, trust: bool, say: Callable[[str], None] | None) -> Modules:
    """Return where modules may stand: never in `home`, which the record fills."""
    origin = Path(info["tree"]).parent
    hint = f"add --trust to execute the modules in {origin}, if you know what they do; or install the package"
    if trust:
        hint = f"put it back into {origin}, where it stood, or install the package"
    return Modules(home, origin if trust else None, hint, say)


def _write_source(name: str, text: str, home: Path, folder: Path) -> None:
    """Write one recorded file; one that was imported from a fixed place has to be there as it was."""
    path = (home / name).resolve()
    if path.is_relative_to(folder):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    elif not Path(name).is_absolute() or not path.is_file() or path.read_text("utf-8") != text:
        raise damaged(path, "the file was imported from here and is gone, or has changed since")


def _interrupts(events: Sequence[Mapping[str, Any]]) -> dict[int, list[Planned]]:
    """Return before which tick the record was interrupted, and by what, in their order."""
    found: dict[int, list[Planned]] = {}
    for event in events:
        if event["type"] == "interrupt":
            group = Planned(event["why"], bool(event.get("stopping")))
            found.setdefault(max(event["tick"], 0) + 1, []).append(group)
    return found


def _compare(recorded: RecordReader, replayed: RecordReader, others: list[str]) -> ReplayResult:
    decisions = sum(event["type"] in DECISIONS for event in recorded.events)
    before, after = (list(_decided(r.events)) for r in (recorded, replayed))
    if not recorded.complete:
        after = after[: len(before)]
    found = compare(before, after)
    if recorded.damage is not None and found.same:
        raise recorded.damage
    return ReplayResult(
        identical=found.identical,
        same=found.same,
        decisions=decisions,
        largest_difference=found.largest,
        first_difference=None if found.first is None else _difference(*found.first),
        until=None if recorded.complete else recorded.until,
        damage=None if recorded.damage is None else str(recorded.damage),
        others=others,
    )


#: names of the faults that devices raise
_FAULTS = {
    cls.__name__ for cls in vars(errors).values() if isinstance(cls, type) and issubclass(cls, errors.DeviceFault)
}


def _decided(events: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the events that a replay repeats: not that a tick was late, nor faults once the task has ended, whose effects the nodes show."""
    stopped = False
    for event in events:
        stopped = stopped or event["type"] == "stop"
        of_device = event["type"] == "fault" or (event["type"] == "stop_error" and event.get("error") in _FAULTS)
        if event["type"] != LATE and not (stopped and of_device):
            yield event


def _difference(old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> dict[str, Any]:
    event = old or new or {}
    node = event.get("path") or event.get("owner") or event.get("device") or event.get("type", "")
    return {"tick": event.get("tick"), "node": node, "recorded": old, "replayed": new}
