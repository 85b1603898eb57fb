"""The table of a characterisation over runs: begun, gone on with, refused."""

import json

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.characterization import NAME, read_table
from stretch_bt.tree.ports import Status


def table_of(path):
    return [(p.geometry, p.size, p.stretch, p.depth, p.trial) for p in read_table(path).presses()]


@pytest.mark.parametrize("rows", range(9))
@pytest.mark.parametrize("torn", ["", "sphere,20,,0", "sphere,20,,0,2,1,0.5,0.01,60,1"])
def test_an_interrupted_table_is_gone_on_with(tmp_path, rows, torn, bench):
    whole = bench(tmp_path / "whole")
    whole.measure()
    first = bench(tmp_path / "first")
    first.measure(rows=rows)
    table = first.context.folder / NAME
    with table.open("a") as file:
        file.write(torn)
    second = bench(tmp_path / "second")
    _, made = second.measure(table=str(table))
    assert (len(made), second.keys["measured"].value.rows) == (8 - rows, 8)
    assert table_of(table) == table_of(whole.context.folder / NAME) == table_of(second.context.folder / NAME)


def test_without_a_record_the_rows_are_in_memory_or_in_the_file_that_is_named(bench, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = bench()
    made.context.folder = None
    made.measure()
    rows = [(p.geometry, p.size, p.stretch, p.depth, p.trial) for p in made.keys["measured"].value.content.presses]
    rows = [(geometry, *(pytest.approx(n) for n in numbers)) for geometry, *numbers in rows]  # a file rounds them
    assert list(tmp_path.iterdir()) == []
    named = bench()
    named.context.folder = None
    named.measure(rows=3, table="table.csv")
    _, left = named.measure(table="table.csv")
    assert len(left) == 5
    assert table_of(tmp_path / "table.csv") == rows
    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]


@pytest.mark.parametrize("kept", [0, 1, 30, 200])
def test_a_table_that_was_cut_in_its_head_begins_anew(bench, tmp_path, kept):
    whole = bench()
    whole.context.folder = tmp_path / "record"
    whole.context.folder.mkdir()
    whole.measure(rows=0)
    table = tmp_path / "table.csv"
    table.write_text((tmp_path / "record" / NAME).read_text()[:kept])
    bench().measure(table=str(table))
    assert len(read_table(table)) == 8


@pytest.mark.parametrize("text", ["a,b\n1,2\n", "a,b", "# stretch-other\n1\n"])
def test_another_file_is_never_written_over(bench, tmp_path, text, small):
    path = tmp_path / "notes.csv"
    path.write_text(text)
    node = bench().node("plan_protocol", table=str(path), **small)
    with pytest.raises(InvalidInput, match=r"notes\.csv:1: a table begins with"):
        next(iter(node.tick()))
    assert path.read_text() == text


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"scene": "wire_circle"},
            "is of scene 'calibration_sphere', this run is of 'wire_circle'; name another table",
        ),
        ({"cell": "mine.yaml"}, "is of cell 'simulated', this run is of 'mine.yaml'"),
        ({"seed": 9}, None),
    ],
)
def test_a_table_of_something_else_is_refused(bench, tmp_path, change, said, small):
    bench().measure(rows=1, table=str(tmp_path / "table.csv"))
    made = bench()
    made.context.about = {**made.context.about, **change}
    node = made.run("plan_protocol", table=str(tmp_path / "table.csv"), **small)
    assert node.status is (Status.FAILURE if said else Status.SUCCESS)
    assert (said or "") in node.reason
    assert len(read_table(tmp_path / "table.csv")) == 1


def test_a_table_of_another_protocol_is_refused(bench, tmp_path):
    bench().measure(rows=1, table=str(tmp_path / "table.csv"))
    node = bench().run("plan_protocol", protocol="paper", table=str(tmp_path / "table.csv"))
    assert "the table is of protocol 'tasks', this run is of 'paper'" in node.reason


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        ({"condition": True}, {"condition": True}, None),
        ({}, {}, None),
        (
            {"condition": True},
            {},
            "conditioned to a stretch of 10 mm and a depth of 2 mm, the membrane of this run not conditioned",
        ),
        ({}, {"condition": True}, "not conditioned, the membrane of this run conditioned to a stretch of 10 mm"),
        (
            {"condition": True},
            {"condition": True, "stretches": [0.0, 0.02]},
            "the membrane of this run conditioned to a stretch of 20 mm",
        ),
    ],
)
def test_a_table_of_a_membrane_that_was_conditioned_otherwise_is_refused(bench, tmp_path, first, second, said, small):
    table = str(tmp_path / "table.csv")
    bench().measure(rows=1, table=table, **first)
    node = bench().run("plan_protocol", table=table, **{**small, **second})
    assert node.status is (Status.FAILURE if said else Status.SUCCESS)
    assert (said or "") in node.reason


@pytest.mark.parametrize("condition", [True, False])
def test_a_table_that_does_not_say_so_is_held_to_be_conditioned(bench, tmp_path, condition, small):
    table = tmp_path / "table.csv"
    bench().measure(rows=1, table=str(table), condition=True)
    head, rest = table.read_text().split("\n", 1)
    kept = json.loads(head.removeprefix("# stretch-characterization/1 "))
    assert kept.pop("conditioned") == {"stretch": 0.01, "depth": 0.002}
    table.write_text(f"# stretch-characterization/1 {json.dumps(kept)}\n{rest}")
    node = bench().run("plan_protocol", table=str(table), condition=condition, **small)
    assert node.status is (Status.SUCCESS if condition else Status.FAILURE)
    assert condition or "held to be conditioned" in node.reason


def test_a_folder_that_is_not_there_is_named(bench, tmp_path, small):
    node = bench().node("plan_protocol", table=str(tmp_path / "none" / "table.csv"), **small)
    with pytest.raises(InvalidInput, match=r"table\.csv: the table cannot be written .* in a folder that exists"):
        next(iter(node.tick()))


def test_a_replay_begins_as_its_record_did_and_touches_nothing_else(tmp_path, bench):
    table = tmp_path / "table.csv"
    for name, rows in (("one", 3), ("two", None)):
        made = bench(tmp_path / name)
        made.measure(rows=rows, table=str(table))
    before = table.read_bytes()
    again = bench(tmp_path / "again")
    again.context.repeated = tmp_path / "two"
    _, made = again.measure(table=str(table))
    assert len(made) == 5
    assert table.read_bytes() == before
    assert table_of(again.context.folder / NAME) == table_of(table)


def test_the_first_line_is_json(bench, tmp_path):
    bench().measure(rows=0)
    first = (tmp_path / NAME).read_text().splitlines()[0]
    assert json.loads(first.removeprefix("# stretch-characterization/1 "))["tree"] is None
