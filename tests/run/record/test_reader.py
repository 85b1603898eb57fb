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
from stretch_bt.run.record import Handed, RecordReader, RunRecord

INTRINSICS = Intrinsics(475.1, 475.3, 11.7, 9.2, 24, 20, (0.1, -0.2, 1e-3, 0.0, 0.3))
FINITE = st.floats(allow_nan=False, allow_infinity=False)
VECTOR = st.tuples(FINITE, FINITE, FINITE)
TIMES = st.floats(0, 1e9)
MAYBE = st.none() | FINITE


def readings(values: st.SearchStrategy[Any]) -> st.SearchStrategy[Reading[Any]]:
    return st.builds(Reading, values, TIMES, TIMES, st.integers(0, 2**60))


def images(shape: tuple[int, int]) -> st.SearchStrategy[np.ndarray]:
    return st.integers(0, 5).map(lambda seed: np.random.default_rng(seed).integers(0, 2**16, shape, np.uint16))


POSES = st.none() | st.builds(Pose, VECTOR, VECTOR)
FRAMES = st.builds(
    DepthFrame, images((20, 24)), FINITE, st.just(INTRINSICS), FINITE, st.integers(0), MAYBE, MAYBE, MAYBE, POSES
)
CROPPED = INTRINSICS.cropped(2, 10, 0, 5)
CROPS = st.builds(DepthFrame, images((8, 5)), FINITE, st.just(CROPPED), FINITE, st.integers(0), MAYBE, MAYBE, MAYBE)
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
        st.text(st.characters(codec="utf-8")),
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
    }
    assert reader.run_info == {"host": "lab", "wall": 1.5}
    assert reader.result is not None
    assert reader.result["outputs"]["depth"]["value"] == 0.005


def test_a_cut_mcap_is_read_as_far_as_it_goes(tmp_path: Path, sample: Any) -> None:
    folder = sample.closed(tmp_path / "r", 12)
    whole = RecordReader(folder)
    expected = [[sample.shown(h) for h in whole.handed(tick)] for tick in range(12)]
    content = (folder / "record.mcap").read_bytes()
    seen = set()
    for length in range(0, len(content), 997):
        (folder / "record.mcap").write_bytes(content[:length])
        reader = RecordReader(folder)
        assert not reader.complete
        assert reader.ticks == whole.ticks[: len(reader.ticks)]
        assert [[sample.shown(h) for h in reader.handed(tick)] for tick, _ in reader.ticks] == expected[
            : len(reader.ticks)
        ]
        seen.add(len(reader.ticks))
    assert seen >= {0, 11}


def test_cut_events_are_read_as_far_as_they_go(tmp_path: Path, sample: Any) -> None:
    folder = sample.closed(tmp_path / "r")
    whole = RecordReader(folder).events
    content = (folder / "events.jsonl").read_bytes()
    for length in range(content.index(b"\n") + 1, len(content), 53):
        (folder / "events.jsonl").write_bytes(content[:length])
        reader = RecordReader(folder)
        assert reader.events == whole[: len(reader.events)]
        assert reader.complete == content[:length].endswith(b"\n")


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_damage_never_gives_other_readings(data: st.DataObject, pristine: Path, sample: Any) -> None:
    whole = RecordReader(pristine)
    content = bytearray((pristine / "record.mcap").read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    with TemporaryDirectory() as place:
        for name in ("events.jsonl", "result.json"):
            (Path(place) / name).write_bytes((pristine / name).read_bytes())
        (Path(place) / "record.mcap").write_bytes(content)
        try:
            reader = RecordReader(Path(place))
        except RecordError as error:  # the damage is in the size of a chunk
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


def test_files_missing_from_a_record(tmp_path: Path, sample: Any) -> None:
    folder = sample.closed(tmp_path / "r")
    for name in ("record.mcap", "run.json", "result.json"):
        (folder / name).unlink()
    reader = RecordReader(folder)
    assert (reader.ticks, reader.run_info, reader.result, reader.complete) == ([], {}, None, False)
    assert len(reader.events) == 19


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
