import json
import math
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from stretch_bt.errors import DeviceLost, InvalidInput, RecordError
from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.record.folder import claim
from stretch_bt.units import Estimate


def test_events_are_compact_sorted_json_with_tick_time_and_type(tmp_path: Path, sample: Any) -> None:
    lines = (sample.closed(tmp_path / "r") / "events.jsonl").read_bytes().splitlines()
    events = [json.loads(line, parse_constant=pytest.fail) for line in lines]
    assert [json.dumps(e, sort_keys=True, separators=(",", ":")).encode() for e in events] == lines
    assert all({"tick", "time", "type"} <= event.keys() for event in events[1:])
    kinds = [event["type"] for event in events]
    assert {kind: kinds.count(kind) for kind in kinds} == {
        "header": 1, "motion": 2, "status": 6, "write": 8, "command": 1, "fault": 1, "overrun": 1,
    }  # fmt: skip
    assert b'"seconds":"Infinity"' in lines[-1]
    assert events[-3]["value"] is None


def test_a_new_command_makes_its_motion_new(tmp_path: Path) -> None:
    record = RunRecord(tmp_path / "r")
    record.start({}, {})
    for _ in range(2):
        record.command("arm", "move", {}, "main/press")
        record.motion("arm", "main/press", MotionState.DONE)
        record.motion("arm", "main/press", MotionState.DONE)
    record.close({})
    reader = RecordReader(record.folder)
    assert [event["type"] for event in reader.events] == ["command", "motion"] * 2
    assert len(reader.motions(-1)) == 4


def test_identical_runs_have_identical_events(tmp_path: Path, sample: Any) -> None:
    first, second = (sample.closed(tmp_path / name) / "events.jsonl" for name in "ab")
    assert first.read_bytes() == second.read_bytes()


def messages(folder: Path) -> Iterator[tuple[Any, Any, Any, Any]]:
    with (folder / "record.mcap").open("rb") as file:
        yield from make_reader(
            file, validate_crcs=True, decoder_factories=[DecoderFactory(), Json()]
        ).iter_decoded_messages()


class Json:
    """What mcap's reader asks for to decode JSON messages."""

    def decoder_for(self, encoding: str, schema: Any) -> Callable[[bytes], Any] | None:
        return json.loads if encoding == "json" else None


def test_mcap_opens_with_the_public_reader_and_schemas(tmp_path: Path, sample: Any) -> None:
    found: dict[tuple[str, str], list[Any]] = {}
    for schema, channel, message, decoded in messages(sample.closed(tmp_path / "r")):
        found.setdefault((channel.topic, schema.name), []).append((message, decoded))
        if schema.encoding == "jsonschema":
            jsonschema.validate(decoded, json.loads(schema.data))
    assert {key: len(value) for key, value in found.items()} == {
        ("/ticks", "stretch.Tick"): 6,
        ("/arm/pose", "stretch.PoseReading"): 6,
        ("/arm/motion", "stretch.Motion"): 6,
        ("/camera/frame", "stretch.DepthFrameReading"): 6,
        ("/camera/depth", "foxglove.RawImage"): 3,
        ("/camera/calibration", "foxglove.CameraCalibration"): 1,
        ("/camera/fault", "stretch.Fault"): 1,
        ("/keys/depth", "stretch.Write"): 6,
        ("/keys/label", "stretch.Write"): 1,
        ("/keys/contact", "stretch.Write"): 1,
        ("/keys/contact", "foxglove.PointCloud"): 1,
        ("/log", "foxglove.Log"): 11,
        ("/files", "stretch.File"): 2,
        ("/marks", "stretch.Mark"): 9,
    }
    message, image = found["/camera/depth", "foxglove.RawImage"][1]
    assert (message.log_time, image.encoding, image.width, image.height, image.step) == (
        100_000_000,
        "16UC1",
        24,
        20,
        48,
    )
    assert image.data == sample.frame(1).value.raw.tobytes()
    _, cloud = found["/keys/contact", "foxglove.PointCloud"][0]
    assert np.frombuffer(cloud.data, "<f4").reshape(-1, 3).tolist() == sample.points.tolist()
    assert [log.message for _, log in found["/log", "foxglove.Log"]][-1] == "seconds=Infinity"


def test_a_reused_buffer_is_not_taken_for_the_same_frame(tmp_path: Path, sample: Any) -> None:
    record = RunRecord(tmp_path / "r")
    record.start({}, {})
    reading = sample.frame(1)
    for count in (1, 1, 2):
        reading.value.raw[:] = count
        record.reading("camera", "frame", reading)
    record.close({})
    found = [r.value.raw[0, 0] for _, _, r in RecordReader(record.folder).readings(-1)]
    assert found == [1, 1, 2]


def test_everything_before_the_present_tick_is_on_the_disk(tmp_path: Path, sample: Any) -> None:
    record = RunRecord(tmp_path / "r")
    sample.run(record, 6)
    reader = RecordReader(tmp_path / "r")
    assert not reader.complete
    assert reader.result is None
    assert reader.ticks == [(tick, tick / 20) for tick in range(5)]
    assert [len(reader.handed(tick)) for tick in range(5)] == [3] * 5
    assert max(event["tick"] for event in reader.events) == 4
    record.close({})
    assert RecordReader(tmp_path / "r").complete


def test_a_folder_is_claimed_only_when_empty(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert RunRecord(tmp_path / "empty").folder == tmp_path / "empty"
    (tmp_path / "full").mkdir()
    (tmp_path / "full/notes.txt").write_text("mine")
    for name in ("full", "full/notes.txt", "full/notes.txt/below"):
        with pytest.raises(RecordError) as caught:
            RunRecord(tmp_path / name)
        assert str(tmp_path / "full") in caught.value.diagnostics[0].file
    assert [p.name for p in (tmp_path / "full").iterdir()] == ["notes.txt"]


def test_of_two_programs_that_claimed_a_folder_the_first_one_keeps_it(tmp_path: Path) -> None:
    first, second = RunRecord(tmp_path / "same"), RunRecord(tmp_path / "same")
    first.start({"by": "first"}, {"by": "first"})
    with pytest.raises(RecordError, match="the folder is not empty"):
        second.start({"by": "second"}, {"by": "second"})
    second.close({"status": "ERROR"})
    first.begin_tick(1, 0.0)
    first.close({"status": "SUCCESS"})
    kept = RecordReader(tmp_path / "same")
    assert (kept.run_info, kept.result) == ({"by": "first"}, {"status": "SUCCESS"})


def test_records_without_a_folder_go_under_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folders = {RunRecord(None).folder for _ in range(3)}
    assert {folder.parent for folder in folders} == {tmp_path / "runs"}
    assert len(folders) == 3


def test_close_is_final(tmp_path: Path, sample: Any) -> None:
    record = RunRecord(tmp_path / "r")
    sample.run(record)
    record.close({"status": "FAILURE"})
    content = {path.name: path.read_bytes() for path in (tmp_path / "r").iterdir()}
    record.close({"status": "SUCCESS"})
    record.begin_tick(9, 9.0)
    record.reading("arm", "pose", Reading(Pose(), 0.0, 0.0, 0))
    record.write("depth", 1.0, None, "main")
    record.status("main", "SUCCESS")
    record.fault("arm", DeviceLost("arm", "gone"))
    record.motion("arm", "main", MotionState.DONE)
    assert {path.name: path.read_bytes() for path in (tmp_path / "r").iterdir()} == content
    assert content.keys() == {"run.json", "events.jsonl", "record.mcap", "result.json"}


def test_a_run_that_never_started_still_has_a_result(tmp_path: Path) -> None:
    record = RunRecord(tmp_path / "r")
    record.close({"status": "ERROR", "value": Estimate(math.nan, np.float32(1))})
    assert json.loads((tmp_path / "r/result.json").read_text())["value"] == {"value": "NaN", "sd": 1.0}


@contextmanager
def full_disk(size: int) -> Iterator[None]:
    """Let files of this process grow no further than a size, as a full disk does; pytest itself may write to one."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_is_said_once_and_leaves_what_was_written(tmp_path: Path, sample: Any) -> None:
    record = RunRecord(tmp_path / "r")
    record.start({}, {})
    refusals: list[str] = []
    with full_disk(20_000):
        for tick in range(60):
            try:
                record.begin_tick(tick, tick / 20)
            except RecordError as error:
                refusals += [d.code for d in error.diagnostics]
            record.reading("camera", "frame", sample.frame(tick))
            record.status("main", f"{tick}")
        record.close({"status": "ERROR"})
    reader = RecordReader(tmp_path / "r")
    assert refusals == ["record-write"]
    assert not reader.complete
    assert reader.result == {"status": "ERROR"}
    assert 5 < len(reader.ticks) < 60
    assert all(
        sample.shown(reader.readings(tick)[0][2]) == sample.shown(sample.frame(tick)) for tick, _ in reader.ticks
    )


def test_a_disk_full_at_the_end_is_said_by_close(tmp_path: Path, sample: Any) -> None:
    record = RunRecord(tmp_path / "r")
    sample.run(record)
    with full_disk(100), pytest.raises(RecordError, match="cannot write"):
        record.close({"status": "SUCCESS"})
    record.close({"status": "SUCCESS"})
    assert not RecordReader(tmp_path / "r").complete


def test_a_note_cannot_hide_its_moment(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="not named tick"):
        RunRecord(tmp_path / "r").note("stop", time=1.0)


def test_a_folder_that_cannot_be_made_has_a_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "runs").write_text("a file")
    monkeypatch.chdir(tmp_path)
    for folder in (None, tmp_path / "runs" / "one", Path("/proc/one")):
        with pytest.raises(RecordError, match=r"cannot make a record here: .*; name another folder with --out"):
            claim(folder)
