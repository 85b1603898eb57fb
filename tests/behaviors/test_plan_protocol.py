"""Which presses are left to make, and what is refused before them."""

import math

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.limits import Limits, Span
from stretch_bt.model.calibration.characterization import NAME, read_table


def places(presses):
    return [(i.geometry, i.size, trial.stretch, trial.number, depth) for i, trial, depth in presses]


def test_presses_come_in_the_order_of_the_protocol(bench, small):
    made = bench()
    made.run("plan_protocol", **small)
    assert places(made.left()) == [
        ("sphere", 0.02, 0.0, 1, 0.0),
        ("sphere", 0.02, 0.0, 1, 0.002),
        ("sphere", 0.02, 0.01, 1, 0.0),
        ("sphere", 0.02, 0.01, 1, 0.002),
        ("sphere", 0.03, 0.0, 1, 0.0),
        ("sphere", 0.03, 0.0, 1, 0.002),
        ("sphere", 0.03, 0.01, 1, 0.0),
        ("sphere", 0.03, 0.01, 1, 0.002),
    ]


def test_an_indenter_is_mounted_once_and_a_trial_begun_once(bench, small):
    left = bench().run("plan_protocol", **{**small, "trials": 2}).sinks["left"].value
    assert (left.presses, [indenter.diameter for indenter in left.indenters]) == (16, [0.02, 0.03])
    for indenter in left.indenters:
        trials = [(trial.stretch, trial.number, trial.depths) for trial in indenter.trials]
        assert trials == [(x, number, [0.0, 0.002]) for x in (0.0, 0.01) for number in (1, 2)]


def test_the_plan_is_of_all_presses_whatever_is_left(bench, small):
    bench().measure(rows=3)
    plan = bench().run("plan_protocol", **small)
    told = plan.sinks["plan"].value
    assert (told.name, told.presses, told.max_stretch, told.max_depth) == ("tasks", 8, 0.01, 0.002)
    assert (plan.sinks["measured"].value.rows, plan.sinks["left"].value.presses) == (3, 5)


def test_a_press_is_left_until_its_row_is_written(bench, small):
    made = bench()
    made.run("plan_protocol", **small)
    first = made.left()
    made.run("plan_protocol", **small)
    assert made.left() == first
    made.write("write_row", first[0], force=0.5)
    made.run("plan_protocol", **small)
    assert places(made.left()) == places(first[1:])


def test_a_cone_has_an_angle(bench, tmp_path):
    _, made = bench().measure(protocol="paper")
    assert {(i.geometry, i.diameter, i.angle) for i, _, _ in made} == {
        *(("sphere", d, 0.0) for d in (0.02, 0.03)),
        *(("cylinder", d, 0.0) for d in (0.02, 0.03)),
        ("cone", 0.0, math.radians(45)),
    }
    assert read_table(tmp_path / NAME).size[-1] == pytest.approx(math.radians(45))


def test_a_protocol_that_does_not_exist_is_known_before_the_run(bench):
    with pytest.raises(InvalidInput, match="no protocol 'papers'"):
        bench().node("plan_protocol", protocol="papers").prepare()


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({"stretches": [0.0, 0.2]}, "stretches: 200 mm is past the limits of the hand; use 0 mm to 80 mm"),
        ({"depths": [0.001, 0.031]}, "depths: 31 mm is past the limits of the hand; use 0 mm to 30 mm"),
        ({"diameters": [0.02, 0.1]}, "diameters: no sphere of 100 mm can be mounted; use 5 mm to 80 mm"),
        ({"diameters": [0.0]}, "diameters: no sphere of 0 mm"),
        ({"table": "FOLDER/none/table.csv"}, "there is no folder"),
        ({"table": "FOLDER"}, "it is a folder"),
        ({"table": "FOLDER/notes.csv"}, r"notes\.csv:1: a table begins with"),
        ({"table": "FOLDER/bytes.csv"}, r"bytes\.csv: the table is no text"),
        ({"table": "FOLDER/paper.csv"}, "the table is of protocol 'paper', this run is of 'tasks'"),
    ],
)
def test_what_no_run_can_reach_is_refused_before_it(bench, tmp_path, inputs, said, small):
    (tmp_path / "notes.csv").write_text("a,b\n1,2\n")
    (tmp_path / "bytes.csv").write_bytes(b"# stretch-characterization/1 \xff\n\n")
    bench().measure(rows=1, table=str(tmp_path / "paper.csv"), protocol="paper")
    before = {path: path.read_bytes() for path in tmp_path.glob("*.csv")}
    asked = {
        name: value.replace("FOLDER", str(tmp_path)) if isinstance(value, str) else value
        for name, value in inputs.items()
    }
    with pytest.raises(InvalidInput, match=said):
        bench().node("plan_protocol", **{**small, **asked}).prepare()
    assert {path: path.read_bytes() for path in tmp_path.glob("*.csv")} == before


def test_the_limits_are_those_of_the_cell(bench, small):
    made = bench()
    made.context.limits = Limits(depth="4 mm", stretch=Span(min="5 mm", max="50 mm"))
    for inputs, said in (
        ({"depths": [0.005]}, "depths: 5 mm .* use 0 mm to 4 mm"),
        ({"stretches": [0.06]}, "stretches: 60 mm .* use 5 mm to 50 mm"),
        ({"stretches": [0.0, 0.03]}, "stretches: 0 mm .* use 5 mm to 50 mm"),
    ):
        with pytest.raises(InvalidInput, match=said):
            made.node("plan_protocol", **{**small, "stretches": [0.03], **inputs}).prepare()


@pytest.mark.parametrize("torn", ["", "sphere,20,,0", "sphere,20,,0,2,1,0.5,0.01,60,1"])
def test_a_table_that_can_be_gone_on_with_is_not_refused_before_the_run(bench, tmp_path, torn, small):
    table = tmp_path / "table.csv"
    bench().node("plan_protocol", table=str(table), **small).prepare()
    assert not table.exists()
    bench().measure(rows=1, table=str(table))
    with table.open("a") as file:
        file.write(torn)
    whole = table.read_bytes()
    bench().node("plan_protocol", table=str(table), **small).prepare()
    assert table.read_bytes() == whole
