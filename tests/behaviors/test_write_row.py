"""The rows of a characterisation."""

import pytest

from stretch_bt.model.calibration.characterization import NAME, read_table


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
    assert table.contact_height.tolist() == [made.context.hand.contact_height] * 2
    assert table.force_sd.tolist() == [0.01, 0.01]
    assert 7.0 <= table.time[0] < table.time[1] < 8.0


def test_a_row_without_a_table_or_a_contact_is_refused(bench, small):
    made = bench()
    row = {"geometry": "sphere", "diameter": 0.02, "force": 0.5}
    assert "run 'next_state' with the same 'table' first" in made.run("write_row", **row).reason
    made.run("next_state", **small)
    made.context.hand.contact_height = None
    assert "run 'approach' first" in made.run("write_row", **row).reason
