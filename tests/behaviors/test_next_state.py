"""What is left to measure, and what is refused before it."""

import math

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.limits import Limits, Span
from stretch_bt.model.calibration.characterization import NAME, read_table


def test_states_come_in_the_order_of_the_protocol(bench):
    _, seen = bench().measure()
    assert seen == [
        ("sphere", 0.02, 0.0, 0.0, 1, True, True, 0),
        ("sphere", 0.02, 0.0, 0.002, 1, False, False, 1),
        ("sphere", 0.02, 0.01, 0.0, 1, False, True, 2),
        ("sphere", 0.02, 0.01, 0.002, 1, False, False, 3),
        ("sphere", 0.03, 0.0, 0.0, 1, True, True, 4),
        ("sphere", 0.03, 0.0, 0.002, 1, False, False, 5),
        ("sphere", 0.03, 0.01, 0.0, 1, False, True, 6),
        ("sphere", 0.03, 0.01, 0.002, 1, False, False, 7),
    ]


def test_a_state_stays_until_its_row_is_written(bench, small, told):
    made = bench()
    node = made.node("next_state", **small)
    made.tick(node)
    first = told(node)
    made.tick(node)
    assert told(node) == (*first[:5], False, False, 0)
    made.write(node)
    made.tick(node)
    assert told(node)[3] == 0.002


def test_a_cone_has_an_angle(bench, tmp_path, small):
    made = bench()
    node = made.node("next_state", **{**small, "protocol": "paper"})
    made.tick(node)
    seen = set()
    while not node.sinks["done"].value:
        seen.add((node.sinks["geometry"].value, node.sinks["diameter"].value, node.sinks["angle"].value))
        made.write(node)
        made.tick(node)
    assert seen == {
        *(("sphere", d, 0.0) for d in (0.02, 0.03)),
        *(("cylinder", d, 0.0) for d in (0.02, 0.03)),
        ("cone", 0.0, math.radians(45)),
    }
    assert read_table(tmp_path / NAME).size[-1] == pytest.approx(math.radians(45))


def test_a_protocol_that_does_not_exist_is_known_before_the_run(bench):
    with pytest.raises(InvalidInput, match="no protocol 'papers'"):
        bench().node("next_state", protocol="papers").prepare()


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
        bench().node("next_state", **{**small, **asked}).prepare()
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
            made.node("next_state", **{**small, "stretches": [0.03], **inputs}).prepare()


@pytest.mark.parametrize("torn", ["", "sphere,20,,0", "sphere,20,,0,2,1,0.5,0.01,60,1"])
def test_a_table_that_can_be_gone_on_with_is_not_refused_before_the_run(bench, tmp_path, torn, small):
    table = tmp_path / "table.csv"
    bench().node("next_state", table=str(table), **small).prepare()
    assert not table.exists()
    bench().measure(rows=1, table=str(table))
    with table.open("a") as file:
        file.write(torn)
    whole = table.read_bytes()
    bench().node("next_state", table=str(table), **small).prepare()
    assert table.read_bytes() == whole
