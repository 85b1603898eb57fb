import os
import re
import threading
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt import errors
from stretch_bt.errors import DeviceFault, RecordError, StaleReading
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.journal import Journal
from stretch_bt.runtime.record import Handed, RecordReader, RunRecord, channels
from stretch_bt.runtime.record.places import Places
from stretch_bt.runtime.record.plain import dumps
from stretch_bt.runtime.record.scan import ChunkFile

INTRINSICS = Intrinsics(475.1, 475.3, 11.7, 9.2, 24, 20, (0.1, -0.2, 1e-3, 0.0, 0.3))
FINITE = st.floats(allow_nan=False, allow_infinity=False)
VECTOR = st.tuples(FINITE, FINITE, FINITE)
TIMES = st.floats(0, 1e9)
MAYBE = st.none() | FINITE
LENGTHS = st.floats(1e-6, 10.0)


def readings(values: st.SearchStrategy[Any]) -> st.SearchStrategy[Reading[Any]]:
    return st.builds(Reading, values, TIMES, TIMES, st.integers(0, 2**60))


def images(shape: tuple[int, int]) -> st.SearchStrategy[np.ndarray]:
    return st.integers(0, 5).map(lambda seed: np.random.default_rng(seed).integers(0, 2**16, shape, np.uint16))


POSES = st.none() | st.builds(Pose, VECTOR, VECTOR)
FRAMES = st.builds(
    DepthFrame,
    images((20, 24)),
    LENGTHS,
    st.just(INTRINSICS),
    FINITE,
    st.integers(0),
    st.none() | LENGTHS,
    MAYBE,
    MAYBE,
    POSES,
)
CROPPED = INTRINSICS.cropped(2, 10, 0, 5)
CROPS = st.builds(
    DepthFrame, images((8, 5)), LENGTHS, st.just(CROPPED), FINITE, st.integers(0), st.none() | LENGTHS, MAYBE, MAYBE
)
FAULTS = st.sampled_from([getattr(errors, n) for n in errors.__all__ if issubclass(getattr(errors, n), DeviceFault)])
HANDED = st.one_of(
    st.builds(Handed, st.just("reading"), st.just("gripper"), st.just("opening"), readings(st.floats())),
    st.builds(Handed, st.just("reading"), st.just("valve"), st.just("state"), readings(st.text() | st.booleans())),
    st.builds(Handed, st.just("reading"), st.just("arm"), st.just("pose"), readings(st.builds(Pose, VECTOR, VECTOR))),
    st.builds(Handed, st.just("reading"), st.just("arm"), st.just("wrench"), readings(st.builds(Wrench, VECTOR))),
    st.builds(Handed, st.just("reading"), st.sampled_from(["a", "b"]), st.just("frame"), readings(FRAMES | CROPS)),
    st.builds(Handed, st.just("motion"), st.just("arm"), st.text(), st.sampled_from(MotionState)),
    st.builds(
        lambda kind, reason: Handed("fault", "arm", "", kind("arm", reason)),
        FAULTS,
        st.text(st.characters(codec="utf-8")).filter(lambda text: Places().without(text) == text),
    ),
)


def give(journal: Journal, handed: Handed) -> None:
    if handed.kind == "reading":
        journal.reading(handed.device, handed.name, handed.value)
    elif handed.kind == "motion":
        journal.motion(handed.device, handed.name, handed.value)
    else:
        journal.fault(handed.device, handed.value)


@settings(max_examples=60, deadline=None)
@given(ticks=st.lists(st.lists(HANDED, max_size=6), max_size=5))
def test_what_nodes_were_handed_comes_back_exactly(ticks: list[list[Handed]], sample: Any) -> None:
    with TemporaryDirectory() as place:
        record = RunRecord(Path(place) / "record")
        record.start({}, {})
        for tick, given_now in enumerate(ticks):
            record.begin_tick(tick, tick / 7)
            for handed in given_now:
                give(record, handed)
        record.close({})
        reader = RecordReader(record.folder)
        assert reader.complete
        assert reader.ticks == [(tick, tick / 7) for tick in range(len(ticks))]
        for tick, given_now in enumerate(ticks):
            assert [sample.shown(h) for h in reader.handed(tick)] == [sample.shown(h) for h in given_now]


def test_the_three_views_of_a_tick(tmp_path: Path, sample: Any) -> None:
    reader = RecordReader(sample.closed(tmp_path / "r"))
    assert [(d, n, type(r.value)) for d, n, r in reader.readings(3)] == [
        ("arm", "pose", Pose),
        ("camera", "frame", DepthFrame),
    ]
    assert reader.motions(5) == [("arm", "main/press", MotionState.DONE)]
    assert [(d, type(f), f.reason) for d, f in reader.faults(5)] == [("camera", StaleReading, "the frame is 0.3 s old")]
    assert reader.faults(4) == []
    assert reader.handed(99) == []


def test_how_it_began_and_ended(tmp_path: Path, sample: Any) -> None:
    reader = RecordReader(sample.closed(tmp_path / "r"))
    assert reader.header == {
        "type": "header",
        "format": "stretch-record/1",
        "tree": {"name": "press"},
        "seed": 0,
        "keys": {"depth": "Length"},
        "marks": True,
    }
    assert reader.run_info == {"host": "lab", "wall": 1.5}
    assert reader.result is not None
    assert reader.result["outputs"]["depth"]["value"] == 0.005


def stages(folder: Path, ticks: int, sample: Any) -> list[tuple[int, int]]:
    """Return how large events.jsonl and record.mcap were after each commit of a run."""
    found = []

    class Spy(RunRecord):
        def begin_tick(self, tick: int, time: float) -> None:
            super().begin_tick(tick, time)
            found.append(tuple((folder / name).stat().st_size for name in ("events.jsonl", "record.mcap")))

    record = Spy(folder)
    sample.run(record, ticks)
    record.close({})
    return found


def cut(folder: Path, events: int, mcap: int) -> None:
    """Leave of a record what a process that was killed had written."""
    for name, size in (("events.jsonl", events), ("record.mcap", mcap)):
        (folder / name).write_bytes((folder / name).read_bytes()[:size])
    (folder / "result.json").unlink(missing_ok=True)


def refusal(folder: Path) -> Any:
    """Return the reader's diagnostic."""
    with pytest.raises(RecordError) as caught:
        RecordReader(folder)
    [found] = caught.value.diagnostics
    return found


def test_a_run_killed_at_any_moment_is_read_to_its_last_whole_tick(tmp_path: Path, sample: Any) -> None:
    """Readings come first, then the events that rest on them, each perhaps in part."""
    sizes, folder = stages(tmp_path / "spied", 8, sample), sample.closed(tmp_path / "r", 8)
    whole = RecordReader(folder)
    handed = [[sample.shown(h) for h in whole.handed(tick)] for tick in range(8)]
    kept = {name: (folder / name).read_bytes() for name in ("events.jsonl", "record.mcap")}
    for tick, ((events, mcap), (next_events, next_mcap)) in enumerate(pairwise(sizes)):
        moments = [(events, size) for size in range(mcap, next_mcap, 211)]
        moments += [(size, next_mcap) for size in range(events, next_events, 37)]
        for moment in moments:
            for name, content in kept.items():
                (folder / name).write_bytes(content)
            cut(folder, *moment)
            reader = RecordReader(folder)
            assert (reader.complete, reader.result) == (False, None)
            assert reader.ticks == whole.ticks[:tick]
            assert reader.events == [event for event in whole.events if event["tick"] < tick]
            assert [[sample.shown(h) for h in reader.handed(k)] for k in range(8)] == handed[:tick] + [[]] * (8 - tick)


@pytest.mark.parametrize("name", ["record.mcap", "events.jsonl"])
def test_a_file_cut_without_the_other_is_damaged(tmp_path: Path, sample: Any, name: str) -> None:
    folder = sample.closed(tmp_path / "r", 12)
    whole = RecordReader(folder)
    content = (folder / name).read_bytes()
    ends = content.index(b"/ticks") if name == "record.mcap" else content.index(b"\n") + 1
    for length in range(ends, len(content) - 1, 97):
        (folder / name).write_bytes(content[:length])
        try:
            reader = RecordReader(folder)
        except RecordError as error:
            [found] = error.diagnostics
            assert (found.code, found.file) == ("record-damaged", str(folder / name))
            if name == "record.mcap":
                byte = int(re.findall(r"cut off at byte (\d+)", found.message)[0])
                assert 0 <= byte <= length
            else:
                assert found.line == content[:length].count(b"\n") + 1
        else:  # as if its process had been killed before it was closed
            assert (name, reader.complete) == ("record.mcap", False)
            assert (reader.ticks, reader.events) == (whole.ticks, whole.events)


def test_a_closed_record_without_its_whole_index_is_damaged(tmp_path: Path, sample: Any) -> None:
    path = sample.closed(tmp_path / "r") / "record.mcap"
    content = path.read_bytes()
    [*_, last] = ChunkFile(path)
    end = last[0] + 9 + int.from_bytes(content[last[0] + 1 : last[0] + 9], "little")
    for length in {*range(end, len(content), 97), len(content) - 1}:
        path.write_bytes(content[:length])
        found = refusal(path.parent)
        assert (found.code, found.file) == ("record-damaged", str(path))
        assert int(re.findall(r"at byte (\d+)", found.message)[0]) <= length
    path.write_bytes(content + b"\0")
    assert f"at byte {len(content) - 8}, or goes on there" in refusal(path.parent).message


@pytest.mark.parametrize("name", ["record.mcap", "run.json", "result.json"])
@pytest.mark.parametrize("content", [None, b"", b"{}"])
def test_a_file_gone_or_empty_is_damaged(tmp_path: Path, sample: Any, name: str, content: bytes | None) -> None:
    path = sample.closed(tmp_path / "r") / name
    path.unlink() if content is None else path.write_bytes(content)
    found = refusal(path.parent)
    assert (found.code, found.file) == ("record-damaged", str(path))
    assert found.hint


def test_a_changed_line_is_named(tmp_path: Path, sample: Any) -> None:
    folder = sample.closed(tmp_path / "r")
    path = folder / "events.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    for number in range(2, len(lines)):
        own = lines[number - 1]
        changes = {
            "flipped": [own.replace(b"a", b"b", 1)],
            "broken": [own[:-9] + b"\n"],
            "deleted": [],
            "doubled": [own, own],
            "empty": [b"\n"],
            "of another kind": [b"[1]\n"],
            "without a time": [own.replace(b'"time"', b'"thyme"')],
        }
        for change in changes.values():
            path.write_bytes(b"".join([*lines[: number - 1], *change, *lines[number:]]))
            found = refusal(folder)
            assert (found.code, found.file) == ("record-damaged", str(path))
            assert 2 <= found.line <= number + 1, "where its tick begins at the earliest, and after the first of two"


def test_a_log_that_was_changed_can_be_asked_for(tmp_path: Path, sample: Any) -> None:
    folder = sample.closed(tmp_path / "r")
    whole = RecordReader(folder).events
    path = folder / "events.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"value":0.003', b'"value":0.00311'))
    reader = RecordReader(folder, changed_log=True)
    assert reader.damage is not None
    assert [new for old, new in zip(whole, reader.events, strict=True) if old != new] == [
        {"key": "depth", "path": "main/press", "sd": 1e-5, "tick": 3, "time": 0.15, "type": "write", "value": 0.00311}
    ]


def test_a_record_without_marks_is_read_as_far_as_it_goes(tmp_path: Path, sample: Any) -> None:
    """The first recorders wrote none: each line is then held against what its readers need."""
    folder = sample.closed(tmp_path / "r")
    path = folder / "events.jsonl"
    content = path.read_bytes().replace(b'"marks":true,', b"")
    path.write_bytes(content[:-5])
    assert len(RecordReader(folder).events) == 18
    path.write_bytes(content.replace(b'"owner":', b'"owned":', 1))
    assert refusal(folder).line == content[: content.index(b'"owner":')].count(b"\n") + 1


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_damage_never_gives_other_readings(data: st.DataObject, pristine: Path, sample: Any) -> None:
    whole = RecordReader(pristine)
    content = bytearray((pristine / "record.mcap").read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    with TemporaryDirectory() as place:
        for name in ("events.jsonl", "run.json", "result.json"):
            (Path(place) / name).write_bytes((pristine / name).read_bytes())
        (Path(place) / "record.mcap").write_bytes(content)
        try:
            reader = RecordReader(Path(place))
        except RecordError as error:
            assert [d.code for d in error.diagnostics] == ["record-damaged"]
            return
        for tick, time in reader.ticks:
            assert (tick, time) in whole.ticks
            found = [sample.shown(h) for h in reader.handed(tick)]
            assert found == [sample.shown(h) for h in whole.handed(tick)][: len(found)]
        if reader.complete:
            assert reader.ticks == whole.ticks


@pytest.fixture(scope="module")
def pristine(tmp_path_factory: pytest.TempPathFactory, sample: Any) -> Path:
    return sample.closed(tmp_path_factory.mktemp("record") / "r", 3)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (None, "record-missing"),
        (b"", "record-format"),
        (b"\x00\xff\xfe", "record-format"),
        (b"[]\n", "record-format"),
        (b"[" * 100_000 + b"\n", "record-format"),
        (b'{"type":"header","format":"stretch-record/9"}\n', "record-format"),
    ],
)
def test_a_foreign_folder_is_refused(tmp_path: Path, content: bytes | None, code: str) -> None:
    if content is not None:
        (tmp_path / "events.jsonl").write_bytes(content)
    with pytest.raises(RecordError) as caught:
        RecordReader(tmp_path)
    (diagnostic,) = caught.value.diagnostics
    assert (diagnostic.code, diagnostic.file) == (code, str(tmp_path / "events.jsonl"))
    assert diagnostic.hint


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="no such folder"):
        RecordReader(tmp_path / "nowhere")


@pytest.mark.parametrize("name", ["run.json", "events.jsonl", "record.mcap", "result.json"])
def test_a_pipe_in_place_of_a_file_is_refused_and_not_waited_for(tmp_path: Path, sample: Any, name: str) -> None:
    path = sample.closed(tmp_path / "r") / name
    path.unlink()
    os.mkfifo(path)
    opened = os.open(path, os.O_RDWR | os.O_NONBLOCK)  # so that a reader that waits finds an end when this closes
    closing = threading.Timer(5.0, os.close, (opened,))
    closing.start()
    assert refusal(path.parent).file == str(path)
    assert closing.is_alive(), "it waited until the pipe was closed"
    closing.cancel()
    os.close(opened)


def test_a_message_nested_too_deep_is_damage(tmp_path: Path, sample: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    deep = b'{"tick": ' + b"[" * 100_000 + b"}"
    monkeypatch.setattr(channels, "dumps", lambda fields: deep if "tick" in fields else dumps(fields))
    record = RunRecord(tmp_path / "r")
    record.start({}, {})
    record.begin_tick(0, 0.0)
    record.close({})
    assert refusal(tmp_path / "r").code == "record-damaged"


def test_a_file_of_a_record_is_told_from_a_missing_folder(tmp_path: Path) -> None:
    """It was said that there is no such folder."""
    file = tmp_path / "run.json"
    file.touch()
    with pytest.raises(RecordError, match=r"record-folder\]: this is a file; a record is a folder; name the folder of"):
        RecordReader(file)
    (tmp_path / "events.jsonl").touch()
    with pytest.raises(RecordError, match=f"name the folder that it is in, {tmp_path}"):
        RecordReader(file)
