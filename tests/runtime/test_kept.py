"""What is kept of a run: everything, the events alone, or nothing."""

import json
from pathlib import Path
from typing import Any, get_args

import pytest

from stretch_bt.errors import InvalidInput, RecordError
from stretch_bt.runtime.onlooker import Visits
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.record.folder import EVENTS, KEPT, RESULT, RUN, Kept
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.report import write_report
from stretch_bt.runtime.task import run

MOCKS = Path(__file__).parents[1] / "trees" / "mocks"
#: fields of a result that differ between two runs, or between what is kept of them
OWN = ("record", "wall_seconds", "cpu_seconds")


@pytest.fixture
def ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run a shipped tree on its mocks in an empty folder, and keep so much of it."""
    monkeypatch.chdir(tmp_path)

    def call(kept: Kept, tree: str = "palpate_stiffness") -> Any:
        out = None if kept == "none" else tmp_path / kept
        return run(tree, mocks=MOCKS / f"{tree}_success.yaml", record=kept, out=out)

    return call


def test_what_is_kept_changes_nothing_of_the_run(ran: Any) -> None:
    results = {kept: ran(kept).to_json() for kept in KEPT}
    plain = [{name: value for name, value in found.items() if name not in OWN} for found in results.values()]
    assert plain[0] == plain[1] == plain[2]
    assert {kept: found["record"] for kept, found in results.items()} == {
        "full": str(Path("full").absolute()),
        "events": str(Path("events").absolute()),
        "none": None,
    }


def test_events_alone_are_those_of_the_whole_record(ran: Any) -> None:
    whole, alone = (Path(ran(kept).record) for kept in ("full", "events"))
    assert sorted(path.name for path in alone.iterdir()) == sorted([RUN, EVENTS, RESULT])
    lines = [(folder / EVENTS).read_text().splitlines() for folder in (whole, alone)]
    assert lines[0][1:] == lines[1][1:]
    read = RecordReader(alone)
    assert read.complete
    assert not read.has_readings
    assert read.result == json.loads((alone / RESULT).read_text())
    assert read.until == json.loads(lines[1][-1])["time"]


def test_events_of_a_killed_run_are_read_up_to_the_last_whole_line(ran: Any) -> None:
    folder = Path(ran("events").record)
    events = (folder / EVENTS).read_bytes()
    (folder / RESULT).unlink()
    (folder / EVENTS).write_bytes(events[:-5])
    read = RecordReader(folder)
    assert not read.complete
    assert len(read.events) == events.count(b"\n") - 2


def test_a_report_is_made_of_events_and_a_replay_is_refused(ran: Any) -> None:
    folder = Path(ran("events").record)
    assert "Nodes over time" in write_report(folder).read_text()
    with pytest.raises(RecordError, match="--record full"):
        replay(folder)


@pytest.mark.parametrize("tree", ["palpate_stiffness", "characterize", "contact_sensitivity", "reconstruct"])
def test_without_a_record_nothing_is_written(ran: Any, tmp_path: Path, tree: str) -> None:
    result = ran("none", tree)
    assert (result.status, result.unmet) == ("SUCCESS", [])
    assert list(tmp_path.iterdir()) == []


def test_a_folder_for_no_record_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="leave out the folder"):
        run("palpate_stiffness", mocks=MOCKS / "palpate_stiffness_success.yaml", record="none", out=tmp_path)


def test_what_is_no_choice_is_refused_with_those_there_are() -> None:
    assert get_args(Kept) == KEPT
    with pytest.raises(InvalidInput, match="full, events, none"):
        run("palpate_stiffness", record="event")  # type: ignore[arg-type]


def test_what_a_long_run_logs_is_kept_of_late_alone() -> None:
    visits = Visits()
    for number in range(10_007):
        visits.status("main/lap:log", "SUCCESS", f"lap {number}")
    assert len(visits.logged) == 10_000
    assert visits.logged[0] == ("main/lap:log", "lap 7")
