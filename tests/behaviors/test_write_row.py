"""The rows of a characterisation."""

import pytest

from stretch_bt.model.calibration.characterization import NAME, read_table
from stretch_bt.runtime.check import check
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Status


def test_rows_hold_what_was_measured_and_where(bench, tmp_path):
    made = bench()
    made.context.now = 7.0
    made.measure(rows=2)
    table = read_table(tmp_path / NAME)
    assert table.provenance["protocol"] == "tasks"
    assert (table.provenance["scene"], table.provenance["seed"], table.provenance["cell"]) == (
        "calibration_sphere",
        4,
        "simulated",
    )
    assert table.provenance["hand"]["gauge"] == 0.1
    assert table.depth.tolist() == pytest.approx([0.0, 0.002])
    assert table.contact_height.tolist() == [0.060] * 2
    assert table.force_sd.tolist() == [0.01, 0.01]
    assert 7.0 <= table.time[0] < table.time[1] < 8.0


def test_the_table_that_a_node_was_given_does_not_grow(bench, small):
    """A table that is kept stays as it was: with a row more it is another one."""
    made = bench()
    made.run("plan_protocol", **small)
    before = made.keys["measured"].value
    made.write("write_row", made.left()[0], force=0.5)
    after = made.keys["measured"].value
    assert (before.rows, len(before.content.presses)) == (0, 0)
    assert (after.rows, len(after.content.presses)) == (1, 1)


@pytest.mark.parametrize("name", ["write_row", "write_diameters"])
def test_a_row_without_a_table_or_a_contact_is_refused_before_the_run(tmp_path, name):
    force = "{force: 1 N}" if name == "write_row" else "{}"
    path = tmp_path / "tree.yaml"
    path.write_text(
        "format: stretch-tree/1\ndevices: {arm: Arm, gripper: Gripper}\n"
        f"trees: {{main: {{sequence: [{name}: {force}]}}}}\n"
    )
    said = "; ".join(d.message for d in check([path]) if d.severity == "error")
    assert "'touch' (Touch)" in said
    assert "$measured is never written" in said


def test_a_row_after_an_indenter_was_changed_is_refused_until_the_hand_touches_it(bench, tmp_path, small):
    made = bench(operator=ScriptedDevice("Operator"))
    made.run("plan_protocol", **small)
    made.run("mount", geometry="sphere", diameter=0.02)
    node = made.write("write_row", made.left()[0], force=0.5)
    assert (node.status, node.reason) == (Status.FAILURE, "$touch is none: main/mount had no value for it")
    assert len(read_table(tmp_path / NAME)) == 0
