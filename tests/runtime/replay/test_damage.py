"""What `replay` and `report` say of records that are damaged, cut short, or put together by somebody else."""

import json
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import StretchError
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.report import write_report
from stretch_bt.runtime.task import run
from stretch_bt.testing.short_runs import short_runs

SMALL = "format: stretch-tree/1\ntrees: {main: {sequence: [wait: {duration: 100 ms}]}}\n"


class Copies(Onlooker):
    """Copies a record at every tick, as its process would leave it that was killed then."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def begin_tick(self, tick: int, time: float) -> None:
        shutil.copytree(self.folder / "record", self.folder / f"killed-{tick}")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a record of the twin, and one of each tick at which it could have been killed."""
    folder = tmp_path_factory.mktemp("runs")
    copies = Copies(folder)
    made = run(**short_runs(folder)["twin"], out=folder / "record", watch=lambda runner: runner.watchers.append(copies))
    assert made.status == "SUCCESS", made.reason
    return folder


@pytest.fixture
def record(runs: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(runs / "record", tmp_path / "record"))


def test_a_killed_run_is_the_same_up_to_a_stated_instant(runs: Path) -> None:
    killed = sorted(runs.glob("killed-*"), key=lambda path: int(path.name.partition("-")[2]))
    assert len(killed) > 5
    for tick, folder in enumerate(killed):
        found = replay(folder)
        assert (found.same, found.identical) == (True, True), found.first_difference
        assert found.until == pytest.approx(max(tick - 1, 0) * 0.05)
        assert "the record ends early" in write_report(folder).read_text("utf-8")
    assert replay(runs / "record").until is None


def test_events_of_a_killed_run_that_were_cut_are_damage(runs: Path, tmp_path: Path) -> None:
    """The record was said to be whole up to an earlier instant, and its replay identical."""
    record = Path(shutil.copytree(sorted(runs.glob("killed-*"))[-1], tmp_path / "record"))
    whole = (record / "events.jsonl").read_bytes()
    (record / "events.jsonl").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(StretchError, match=r"bytes shorter than it was|this line is cut off"):
        replay(record)


@pytest.mark.parametrize("name", ["run.json", "events.jsonl", "record.mcap", "result.json"])
@pytest.mark.parametrize("way", ["gone", "empty", "halved", "flipped"])
def test_damage_is_said_with_its_place(record: Path, name: str, way: str) -> None:
    path = record / name
    content = path.read_bytes()
    half = len(content) // 2
    changed = {"empty": b"", "halved": content[:half], "flipped": content[:half] + b"\xff" + content[half + 1 :]}
    path.unlink() if way == "gone" else path.write_bytes(changed[way])
    for ask in (replay, write_report):
        with pytest.raises(StretchError) as caught:
            ask(record)
        assert f"{path}:" in str(caught.value)
        assert "error[record-" in str(caught.value)


def test_a_decision_that_was_edited_differs_and_is_said_to_be_damaged(record: Path) -> None:
    path = record / "events.jsonl"
    path.write_bytes(
        path.read_bytes().replace(b'"stretch":0.01', b'"stretch":0.02').replace(b'"RUNNING"', b'"SUCCESS"', 1)
    )
    found = replay(record)
    assert not found.same
    assert found.first_difference is not None
    assert found.damage is not None
    assert f"{path}:" in found.damage


def test_a_digit_that_was_edited_is_said_to_be_damaged(record: Path) -> None:
    path = record / "events.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    number, line = next((n, line) for n, line in enumerate(lines) if b'"largest":' in line or b'"speed":0.1' in line)
    lines[number] = line.replace(b'"speed":0.1', b'"speed":0.10000000000000002').replace(b'"mean":0.', b'"mean":0.0', 0)
    path.write_bytes(b"".join(lines))
    with pytest.raises(StretchError, match="is not as it was written"):
        replay(record)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False) | st.text(max_size=5) | st.integers(-(10**20), 10**20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
INFO = ("tree", "sources", "set", "seed", "scene", "cell", "hand", "limits", "mocks", "started", "versions", "modules")
HEADER = ("tree", "params", "seed", "scene", "cell", "keys", "versions", "files")


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(INFO), st.sampled_from(HEADER), st.tuples(*[JSON] * 5))
def test_a_record_that_somebody_put_together_gives_no_traceback(field: str, entry: str, values: Any) -> None:
    """Its digests hold, and anything may stand in its files."""
    with TemporaryDirectory() as place:
        record = RunRecord(Path(place) / "record")
        info = {"tree": "/nowhere/tree.yaml", "sources": {"tree.yaml": SMALL}, "set": {}, "seed": 0}
        header = {"tree": "tree.yaml", "keys": {}, "params": {}}
        record.start({**header, entry: values[0]}, {**info, field: values[1]})
        for tick in range(3):
            record.begin_tick(tick, tick / 20)
            record.write("key", values[2], None, "main")
        record.close({"status": "SUCCESS", "outputs": values[3], "truth": values[4]})
        assert RecordReader(record.folder).complete
        for ask in (replay, write_report):
            try:
                ask(record.folder)
            except StretchError as error:
                assert str(error)


def test_last_digits_of_another_processor_are_the_same(record: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A number that comes out otherwise in its last digit, as under other kernels."""
    before = RunRecord.command

    def command(self: RunRecord, device: str, name: str, arguments: Any, owner: str) -> None:
        before(
            self, device, name, {k: v * (1 + 1e-12) if isinstance(v, float) else v for k, v in arguments.items()}, owner
        )

    monkeypatch.setattr(RunRecord, "command", command)
    found = replay(record)
    assert (found.identical, found.same) == (False, True)
    assert 0 < found.largest_difference < 1e-11
    assert found.first_difference is not None
    assert json.dumps(found.to_json())
