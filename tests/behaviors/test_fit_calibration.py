"""A model that is fitted in a run serves the nodes that come later."""

import pytest

from stretch_bt import run
from stretch_bt.errors import InvalidInput
from stretch_bt.model import ForceModel
from stretch_bt.model.calibration.characterization import NAME, PressRow, first_lines, table_line
from stretch_bt.model.force.force_model import shipped
from stretch_bt.tree.ports import Status

TREE = """\
format: stretch-tree/1
trees:
  main:
    out: {force: Force, residual: float, presses: int}
    sequence:
      - fit_calibration: {table: TABLE, fit: FIT, residual: $residual, presses: $presses}
      - predict_force: {radius: 12 mm, stretch: 20 mm, depth: 8 mm, model: fitted, force: $force}
"""


@pytest.fixture
def table(tmp_path):
    model = shipped("membrane")
    path = tmp_path / "presses.csv"
    rows = [
        PressRow("sphere", d, x, z, 1, model.predict(d / 2, x, z)[0], 0.005, 0.05, 0.0)
        for d in (0.01, 0.02, 0.04)
        for x in (0.0, 0.03, 0.06)
        for z in (0.003, 0.007, 0.012)
    ]
    path.write_text(first_lines({"scene": "test"}) + "".join(map(table_line, rows)), "utf-8")
    return path


def tree(folder, text):
    path = folder / "tree.yaml"
    path.write_text(text, "utf-8")
    return path


@pytest.mark.parametrize("fit", ["membrane", "paper"])
def test_later_nodes_use_what_was_fitted(tmp_path, table, fit):
    path = tree(tmp_path, TREE.replace("TABLE", f"'{table}'").replace("FIT", fit))
    result = run(path, out=tmp_path / "record")
    assert result.status == "SUCCESS"
    own, _ = shipped("membrane").predict(0.012, 0.02, 0.008)
    assert result.outputs["force"]["value"] == pytest.approx(own, rel=0.02 if fit == "membrane" else 0.15)
    assert result.outputs["presses"]["value"] == 27
    kept = ForceModel.load(tmp_path / "record" / "calibration.json")
    assert kept.predict(0.012, 0.02, 0.008)[0] == pytest.approx(result.outputs["force"]["value"])


def test_without_the_name_of_a_table_it_is_that_of_the_run(bench, tmp_path):
    model, made = shipped("membrane"), bench()
    made.run(
        "plan_protocol", diameters=[0.01, 0.02, 0.04], stretches=[0.0, 0.03, 0.06], depths=[0.003, 0.007], trials=1
    )
    for press in made.left():
        indenter, trial, depth = press
        force, _ = model.predict(indenter.diameter / 2, trial.stretch, depth)
        made.write("write_row", press, force=force, force_sd=0.005)
    fits = [made.run("fit_calibration", **table).sinks for table in ({}, {"table": str(tmp_path / NAME)})]
    assert [fit["presses"].value for fit in fits] == [18, 18]
    own, named = (fit["fitted"].value.predict(0.012, 0.02, 0.006) for fit in fits)
    assert own == pytest.approx(named, rel=1e-3)


def test_without_any_table_there_is_nothing_to_fit_to(bench):
    node = bench().run("fit_calibration")
    assert node.status is Status.FAILURE
    assert node.reason == "there is no table to fit to; name a file as 'table', or run 'plan_protocol' first"


def test_without_a_fit_there_is_no_model(tmp_path):
    text = """\
format: stretch-tree/1
keys: {force: Force}
trees:
  main:
    sequence:
      - predict_force: {radius: 12 mm, stretch: 20 mm, depth: 8 mm, model: fitted, force: $force}
"""
    result = run(tree(tmp_path, text), out=tmp_path / "record")
    assert result.status == "FAILURE"
    assert "fit_calibration" in result.reason


def test_a_missing_table_is_refused_before_anything_moves(tmp_path):
    path = tree(tmp_path, TREE.replace("TABLE", "nothing.csv").replace("FIT", "membrane"))
    with pytest.raises(InvalidInput, match="cannot be read"):
        run(path, out=tmp_path / "record")


def test_an_unknown_model_is_refused_before_anything_moves(tmp_path, table):
    path = tree(tmp_path, TREE.replace("TABLE", f"'{table}'").replace("FIT", "spring"))
    with pytest.raises(InvalidInput, match="spring"):
        run(path, out=tmp_path / "record")


def test_a_table_that_the_run_writes_itself_is_not_asked_for_before_it(tmp_path):
    name = tmp_path / "own.csv"
    text = TREE.replace("table: TABLE, ", "").replace("FIT", "membrane")
    begin = f"      - plan_protocol: {{table: '{name}', diameters: [20 mm], stretches: [0 mm], depths: [2 mm]}}\n"
    text = text.replace("      - fit_calibration", begin + "      - fit_calibration")
    result = run(tree(tmp_path, text), out=tmp_path / "record")
    assert result.status == "FAILURE"
    assert result.reason.startswith("main/fit_calibration: ")
    assert "no table" not in result.reason
    assert name.exists()
