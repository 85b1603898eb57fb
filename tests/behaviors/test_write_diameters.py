"""The rows of a sensitivity map, over runs: begun, gone on with, refused."""

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.sensitivity import METHODS, NAME, Found, read_sensitivity
from stretch_bt.tree.ports import Status

SMALL = {"protocol": "sensitivity", "diameters": [0.02], "stretches": [0.0, 0.01], "depths": [0.005, 0.01], "trials": 1}
FOUND = (Found("fit", 0.021, 1e-4, 0.018, 2e-4, "ellipse"), *(Found(m, refused="it, or not") for m in METHODS[1:]))


def measure(made, presses=None, table=""):
    """Plan, and write the sizes found at each press that remains, or at so many; return how many."""
    made.run("plan_protocol", **SMALL, table=table)
    left = made.left()[:presses]
    for press in left:
        assert made.write("write_diameters", press, found=FOUND).status is Status.SUCCESS
    return len(left)


def places(path):
    return [(p.size, p.stretch, p.depth, p.trial) for p in read_sensitivity(path).rows]


def test_a_press_holds_what_each_method_found_and_where(bench, tmp_path):
    made = bench()
    made.context.now = 7.0
    measure(made, presses=1)
    table = read_sensitivity(tmp_path / NAME)
    assert (table.provenance["protocol"], table.provenance["scene"]) == ("sensitivity", "calibration_sphere")
    (press,) = table.rows
    assert press.found[0].i == pytest.approx(0.021)
    assert [f.refused for f in press.found] == ["", "it, or not", "it, or not"]
    assert (press.size, press.depth, press.stretch) == pytest.approx((0.02, 0.005, 0.0), abs=1e-9)
    assert 7.0 <= press.time < 8.0


@pytest.mark.parametrize("presses", range(5))
@pytest.mark.parametrize("lines", [0, 1, 2])
@pytest.mark.parametrize("torn", ["", "20,0,5,1,fi"])
def test_an_interrupted_map_is_gone_on_with(bench, tmp_path, presses, lines, torn):
    whole, table = tmp_path / "whole", tmp_path / "table.csv"
    measure(bench(whole))
    measure(bench(tmp_path / "first"), presses=presses, table=str(table))
    rows = (whole / NAME).read_text().splitlines(keepends=True)[2 + 3 * presses :]
    with table.open("a") as file:
        file.write("".join(rows[:lines]) + torn)
    second = bench(tmp_path / "second")
    seen = measure(second, table=str(table))
    assert seen == 4 - presses
    assert places(table) == places(whole / NAME) == places(second.context.folder / NAME)


def test_a_table_of_forces_is_not_gone_on_with(bench, tmp_path):
    forces = tmp_path / "forces.csv"
    bench().measure(rows=1, table=str(forces))
    before = forces.read_bytes()
    node = bench().node("plan_protocol", **SMALL, table=str(forces))
    with pytest.raises(InvalidInput, match="a table begins with '# stretch-sensitivity/1 '"):
        node.prepare()
    assert forces.read_bytes() == before


def test_a_row_of_another_kind_is_refused(bench, tmp_path):
    made = bench()
    measure(made, presses=1)
    made.run("plan_protocol", **SMALL)
    before = (tmp_path / NAME).read_bytes()
    forces = made.write("write_row", made.left()[0], force=0.5)
    assert (forces.status, "another 'protocol'" in forces.reason) == (Status.FAILURE, True)
    assert (tmp_path / NAME).read_bytes() == before


def test_the_mean_error_is_that_of_the_table(bench):
    made = bench()
    measure(made)
    node = made.run("mean_diameter_error", method="fit", least_depth=0.005)
    assert node.sinks["error"].value == pytest.approx(1.5e-3)
    refused = made.run("mean_diameter_error", method="paper_fit", least_depth=0.005)
    assert (refused.status, "measured none of 4 presses" in refused.reason) == (Status.FAILURE, True)
