"""A motion that may meet something harder than the cell allows is found before anything moves."""

import re

import pytest

from stretch_bt import check
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.peak_force import peak_force

CELL = """\
format: stretch-cell/1
devices:
  arm:
    type: Arm
    use: ur
    host: 192.168.1.10
    model: MODEL
    base: {x: -500 mm}
    hand: {z: 300 mm, rx: 180 deg}
    source: an example
limits: {speed: 250 mm/s, LIMITS}
"""
TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
params: {fast: {type: Speed, default: 10 mm/s, max: 50 mm/s}}
keys: {speed: Speed, touch: Touch}
trees:
  main:
    BODY
"""
MARKED = re.compile("«(.*?)»", re.DOTALL)


@pytest.fixture
def found(tmp_path):
    """Check a tree against a cell: the findings of forces, the marked place, and the cell."""

    def held(body, limits="force: 20 N", model="ur5"):
        steps = body.removeprefix("sequence: [").removesuffix("]") if body.startswith("sequence") else body
        text = TREE.replace("BODY", f"sequence: [set: {{touch: none}}, {steps}]")
        tree, cell = tmp_path / "tree.yaml", tmp_path / "cell.yaml"
        tree.write_text(MARKED.sub(r"\1", text))
        cell.write_text(CELL.replace("MODEL", model).replace("LIMITS", limits))
        mark = MARKED.search(text)
        place = mark and (text.count("\n", 0, mark.start()) + 1, mark.start() - text.rfind("\n", 0, mark.start()))
        return [d for d in check(tree, cell=cell) if d.code == "cell-force"], place, load_cell(cell)

    return held


@pytest.mark.parametrize("model", ["ur5", "ur5e"])
@pytest.mark.parametrize("stiffness", [1, 5, 20, 200])
@pytest.mark.parametrize("speed", [5, 10, 20, 50, 100, 250])
def test_it_warns_where_the_computed_peak_is_above_the_one_that_is_allowed(found, speed, stiffness, model):
    limits = f"force: 20 N, stiffness: {stiffness} N/mm"
    warnings, place, spec = found(f"roll: {{speed: «{speed} mm/s»}}", limits, model)
    peak = peak_force(speed / 1e3, stiffness * 1e3, 20.0, spec.devices["arm"].options.stopping(spec.limits))
    assert bool(warnings) == (peak.stopped > 75.0)
    for warning in warnings:
        assert (warning.line, warning.column, warning.severity) == (*place, "warning")
        assert (
            f"main/roll: speed: at {speed} mm/s and {stiffness} N/mm a contact force rises to {peak.stopped:.0f} N"
            in warning.message
        )
        assert f"to {peak.late:.0f} N where the connection fails meanwhile" in warning.message
        assert "begins to stop at 20 N, and cell.yaml allows peaks of 75 N" in warning.message


def test_the_speed_of_the_remedy_is_slow_enough_and_a_faster_one_is_not(found):
    [warning], *_ = found("roll: {speed: 250 mm/s}")
    fast = float(re.search(r"use at most ([\d.]+) mm/s", warning.hint)[1])
    assert found(f"roll: {{speed: {fast} mm/s}}")[0] == []
    assert found(f"roll: {{speed: {1.1 * fast} mm/s}}")[0]


PLACES = {
    "a default": ("«move_over»: {x: 0 mm, y: 0 mm}", "main/move_over: speed: at 100 mm/s"),
    "a param at the end of its range": ("press: {depth: 1 mm, speed: $fast}", "at the end of its range, fast = 50 mm/s, main/press"),
    "what only the run knows": (
        "sequence: [set: {speed: task.time * 1 mm/s^2}, roll: {speed: «$speed»}]",
        "main/roll: speed: at 250 mm/s",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", PLACES)
def test_every_speed_that_a_motion_can_have_counts(found, case):
    body, said = PLACES[case]
    [warning], place, _ = found(body)
    assert said in warning.message
    assert (warning.line, warning.column) == (place or (3, 10))


# (tree, limits) without a warning: slow, soft, above where anything can be met, and past a limit, which is an error of its own
QUIET = [
    ("press: {depth: 1 mm, speed: 40 mm/s}", "force: 20 N"),
    ("roll: {speed: 250 mm/s}", "force: 20 N, stiffness: 0.5 N/mm"),
    ("roll: {speed: 100 mm/s}", "force: 20 N, peak_force: 150 N"),
    ("move_over: {x: 0 mm, y: 0 mm}", "force: 20 N, contact: {below: 100 mm, speed: 30 mm/s}"),
    ("roll: {speed: 50 mm/s}", "force: 20 N, contact: {below: 100 mm, speed: 30 mm/s}"),
]


@pytest.mark.parametrize(("body", "limits"), QUIET)
def test_it_is_silent_where_nothing_is_met_hard(found, body, limits):
    assert found(body, limits)[0] == []


def test_a_limit_of_force_above_the_allowed_peak_is_named_as_what_to_change(found):
    [warning], *_ = found("roll: {speed: 5 mm/s}", "force: 90 N")
    assert warning.hint.startswith("lower 'limits: {force: ...}'")


def test_a_simulated_arm_meets_nothing_real(tmp_path):
    (tmp_path / "tree.yaml").write_text(TREE.replace("BODY", "sequence: [set: {touch: none}, roll: {speed: 250 mm/s}]"))
    assert [d for d in check(tmp_path / "tree.yaml", cell="simulated") if d.code == "cell-force"] == []
