"""A signal before the first tick, between any two steps, and after the last; and what breaks after the last tick."""

import json
import os
import signal
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.errors import DeviceLost, InvalidInput
from stretch_bt.hardware import cell as cell_module
from stretch_bt.hardware.cell import Cell
from stretch_bt.runtime import execute as execute_module
from stretch_bt.runtime.record import RunRecord
from stretch_bt.runtime.task import run

TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
scene: water_balloon
trees: {main: {sequence: [{retract: {clearance: 20 mm}}]}}
"""


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    (tmp_path / "tree.yaml").write_text(TREE)
    return tmp_path / "tree.yaml"


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each device that was opened was closed."""
    found: Counter[str] = Counter()
    close = Cell.close

    def counted(cell: Cell) -> Any:
        found.update(cell.devices.keys())
        return close(cell)

    monkeypatch.setattr(Cell, "close", counted)
    return found


def strike() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def struck(call: Any, when: str) -> Any:
    """Return a call that a signal comes before, after, or before without being able to break it off."""

    def both(*args: Any, **options: Any) -> Any:
        if when == "swallowed":
            with suppress(KeyboardInterrupt):
                strike()
        if when == "before":
            strike()
        result = call(*args, **options)
        if when == "after":
            strike()
        return result

    return both


STEPS = [
    (RunRecord, "__init__"),
    (RunRecord, "start"),
    (cell_module, "open_cell"),
    (execute_module, "Truths"),
    (execute_module, "Runner"),
    (execute_module, "result_of"),
    (RunRecord, "close"),
    (execute_module, "write_report"),
]


@pytest.mark.parametrize("when", ["before", "after", "swallowed"])
@pytest.mark.parametrize(("place", "name"), STEPS, ids=[name for _, name in STEPS])
def test_a_signal_at_any_step_ends_the_run_and_is_in_its_result(
    tree: Path, closed: Counter[str], monkeypatch: pytest.MonkeyPatch, place: Any, name: str, when: str
) -> None:
    monkeypatch.setattr(place, name, struck(getattr(place, name), when))
    before = signal.getsignal(signal.SIGINT)
    result = run(tree, out=tree.parent / "record")
    assert result.status == "INTERRUPTED"
    assert "SIGINT" in result.reason
    early = STEPS.index((place, name)) < 5
    assert (result.ticks == 0) == early, result.reason
    kept = json.loads((tree.parent / "record/result.json").read_text())
    if STEPS.index((place, name)) < 6:
        assert (kept["status"], kept["reason"]) == (result.status, result.reason)
    else:  # a record that is being closed says how the task ended
        assert (kept["status"], kept["reason"]) == ("SUCCESS", "")
    assert set(closed) in ({"arm"}, set())
    assert signal.getsignal(signal.SIGINT) is before


def test_a_signal_between_opening_and_the_first_tick_is_heard(tree: Path) -> None:
    result = run(tree, out=tree.parent / "record", watch=lambda _: strike())
    assert (result.status, result.ticks) == ("INTERRUPTED", 0)


@pytest.mark.parametrize("place", ["write_report", "stats"])
@pytest.mark.parametrize("error", [ValueError("broken"), KeyError("time"), RecursionError("deep")])
def test_what_breaks_after_the_last_tick_changes_nothing(
    tree: Path, monkeypatch: pytest.MonkeyPatch, place: str, error: Exception
) -> None:
    def broken(*_: Any) -> Any:
        raise error

    if place == "write_report":
        monkeypatch.setattr(execute_module, "write_report", broken)
    else:
        monkeypatch.setattr(Cell, "stats", broken)
    result = run(tree, out=tree.parent / "record")
    assert (result.status, len(result.errors)) == ("SUCCESS", 1)
    assert type(error).__name__ in result.errors[0]
    assert json.loads((tree.parent / "record/result.json").read_text())["status"] == "SUCCESS"


@pytest.mark.parametrize(
    ("end", "outputs"), [("wait: {duration: 0 s}", {"felt", "least"}), ("fail: lost it", {"felt"})]
)
def test_a_failed_run_has_the_outputs_that_it_wrote_and_no_default(tmp_path: Path, end: str, outputs: set[str]) -> None:
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\n"
        "trees:\n"
        "  main:\n"
        "    out: {felt: {type: Force, default: 9 N}, least: {type: Force, default: 1000 N}}\n"
        f"    sequence: [set: {{felt: 2 N}}, {end}]\n"
    )
    assert run(tmp_path / "tree.yaml", out=tmp_path / "record").outputs.keys() == outputs


@pytest.mark.parametrize("place", ["start", "update", "stop"])
def test_a_view_that_breaks_leaves_the_run_what_it_was(tree: Path, place: str) -> None:
    class Breaks:
        def start(self, outline: Any) -> None:
            self.at("start")

        def update(self, now: float, statuses: Any) -> None:
            self.at("update")

        def stop(self) -> None:
            self.at("stop")

        def at(self, name: str) -> None:
            if name == place:
                raise ValueError("broken")

    result = run(tree, out=tree.parent / "record", view=Breaks())
    assert (result.status, result.errors) == ("SUCCESS", ["the view broke (ValueError: broken)"])


def test_a_signal_in_the_last_closing_is_in_the_result(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    close, calls = Cell.close, []

    def late(cell: Cell) -> Any:
        calls.append(cell)
        if len(calls) == 2:
            strike()
        return close(cell)

    monkeypatch.setattr(Cell, "close", late)
    assert "SIGINT came after the task had ended with SUCCESS" in run(tree, out=tree.parent / "record").reason


def test_a_cell_whose_simulated_devices_a_task_leaves_alone_needs_no_scene(tmp_path):
    from stretch_bt.runtime.task import run

    tree = tmp_path / "tree.yaml"
    tree.write_text("format: stretch-tree/1\ntrees: {main: {sequence: [wait: {duration: 100 ms}]}}\n", encoding="utf-8")
    assert run(tree, cell="simulated", out=tmp_path / "record").status == "SUCCESS"
    moving = tmp_path / "moving.yaml"
    body = "scene: water_balloon\ntrees: {main: {sequence: [set_stretch: {stretch: 5 mm}]}}\n"
    moving.write_text(f"format: stretch-tree/1\ndevices: {{gripper: Gripper}}\n{body}", encoding="utf-8")
    with pytest.raises(InvalidInput, match="name one with --scene: the scene of the tree counts where no cell is"):
        run(moving, cell="simulated", out=tmp_path / "other")


def test_a_run_whose_devices_do_not_open_has_a_whole_record(
    tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lost(*_: Any, **options: Any) -> Any:
        raise DeviceLost("arm", "no answer")

    monkeypatch.setattr(cell_module, "open_cell", lost)
    with pytest.raises(DeviceLost) as caught:
        run(tree, out=tmp_path / "r")
    assert caught.value.record == str(tmp_path / "r")
    result = json.loads((tmp_path / "r" / "result.json").read_text())
    assert (result["status"], result["ticks"], result["record"]) == ("FAULT", 0, str(tmp_path / "r"))
    assert "no answer" in result["reason"]
    assert (tmp_path / "r" / "report.html").exists()
