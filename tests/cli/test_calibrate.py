"""`calibrate` and `predict`."""

import json
import os

import pytest

from stretch_bt.model.calibration.characterization import NAME, first_lines, table_line
from stretch_bt.model.calibration.characterization import PressRow as Row
from stretch_bt.model.force.force_model import shipped

DIAMETERS, STRETCHES, DEPTHS = (0.01, 0.02, 0.03, 0.06), (0.0, 0.03, 0.06), (0.002, 0.005, 0.009, 0.014)


@pytest.fixture
def record(tmp_path):
    """Return a folder with the table of presses that the shipped membrane model would feel."""
    model = shipped("membrane")
    states = [(d, x, z) for d in DIAMETERS for x in STRETCHES for z in DEPTHS]
    rows = [
        Row("sphere", d, x, z, 1, model.predict(d / 2, x, z)[0], 0.005, 0.05, float(k))
        for k, (d, x, z) in enumerate(states)
    ]
    folder = tmp_path / "record"
    folder.mkdir()
    (folder / NAME).write_text(first_lines({"scene": "test"}) + "".join(map(table_line, rows)), "utf-8")
    return folder


@pytest.fixture(scope="module")
def kept():
    """What the first test that needs it keeps for the others: the calibration of that table, and what was printed."""
    return []


@pytest.fixture
def calibrated(cli, record, tmp_path, kept):
    """Return a file with the calibration of the table, and the output printed as it is made."""
    out = tmp_path / "hand.json"
    if not kept:
        code, printed, _ = cli("calibrate", record / NAME, "--out", out)
        assert code == 0
        kept += [out.read_text(), printed]
    out.write_text(kept[0])
    return out, kept[1]


@pytest.mark.parametrize("model", ["membrane", "paper", pytest.param("sheet", marks=pytest.mark.slow)])
def test_a_calibration_is_written_and_predicts(cli, record, tmp_path, model):
    out = tmp_path / "hand.json"
    code, printed, _ = cli("calibrate", record, "--out", out, "--model", model, "--json")
    told = json.loads(printed)
    assert code == 0
    assert told["provenance"]["characterization"] == {"scene": "test"}
    assert {r["diameter"] for r in told["residuals"]} == set(DIAMETERS)
    assert len(told["leave_one_out"]) == len(DIAMETERS)
    code, printed, _ = cli(
        "predict", "--calibration", out, "--radius", "12mm", "--stretch", "20mm", "--depth", "8mm", "--json"
    )
    found = json.loads(printed)
    assert (code, found["in_range"]) == (0, True)
    own, _ = shipped("membrane").predict(0.012, 0.02, 0.008)
    assert found["force_N"] == pytest.approx(own, rel=0.15 if model == "paper" else 0.02)
    assert 0 < found["sd_N"] < 0.3 * own


def test_what_lies_outside_has_no_answer(cli, calibrated):
    out, _ = calibrated
    code, printed, _ = cli(
        "predict", "--calibration", out, "--radius", "12mm", "--stretch", "200mm", "--depth", "8mm", "--json"
    )
    found = json.loads(printed)
    assert (code, found["in_range"], found["force_N"]) == (1, False, None)
    assert "stretch 200 mm" in found["reason"]


def test_beyond_what_was_measured_is_not_in_range(cli, calibrated):
    out, _ = calibrated
    asked = ("predict", "--calibration", out, "--radius", "12mm", "--stretch", "78mm", "--depth", "8mm")
    code, printed, _ = cli(*asked, "--json")
    found = json.loads(printed)
    assert (code, found["in_range"]) == (0, False)
    assert found["force_N"] > found["sd_N"] > 0.01 * found["force_N"]
    assert "beyond what was measured" in cli(*asked)[1]


def test_an_indenter_that_the_table_does_not_know_is_left_out_with_a_warning(cli, record, tmp_path):
    path = record / NAME
    rows = [line for line in path.read_text("utf-8").splitlines(True) if line.startswith("sphere,10,")]
    with path.open("a") as file:
        file.writelines(row.replace("sphere,10,", "sphere,6,") for row in rows)
    code, printed, errors = cli("calibrate", record, "--out", tmp_path / "hand.json", "--json")
    assert code == 0
    assert json.loads(printed)["warnings"] == ["left out: diameter 6 mm, outside of 8 mm to 120 mm"]
    assert "warning: left out: diameter 6 mm" in errors
    assert json.loads((tmp_path / "hand.json").read_text())["provenance"]["left_out"]


def test_a_parameter_at_its_bound_is_said_to_be_there(calibrated):
    out, printed = calibrated
    hand = json.loads(out.read_text())["hand"]
    at_bound = [name for name, value in hand.items() if value == 0]
    assert at_bound
    for name in hand:
        line = next(line for line in printed.splitlines() if line.startswith(name))
        assert ("0 (at its bound)" in line) == (name in at_bound)


def test_the_papers_parameters_are_printed_in_their_units(cli, record, tmp_path):
    out = tmp_path / "hand.json"
    printed = cli("calibrate", record, "--out", out, "--model", "paper")[1]
    state = json.loads(out.read_text())["states"][1]
    lines = dict(line.split("  ", 1) for line in printed.splitlines() if " at 30 mm" in line)
    for name, unit, scale in (("floor", "kPa", 1e3), ("amplitude", "kPa", 1e3), ("decay", "mm", 1e-3)):
        value, _, sd = lines[f"{name} at 30 mm, {unit}"].split()
        assert float(value) == pytest.approx(state[name] / scale, rel=1e-4)
        assert float(sd) == pytest.approx(state[f"{name}_sd"] / scale, rel=0.06)


def test_a_softening_that_was_held_is_not_said_to_be_at_its_bound(cli, record, tmp_path):
    path = record / NAME
    head, *rows = path.read_text("utf-8").splitlines(True)
    mark, _, told = head.partition("{")
    provenance = {**json.loads("{" + told), "conditioned": {"stretch": 0.0, "depth": 0.0}}
    path.write_text("".join([mark + json.dumps(provenance) + "\n", *rows]), encoding="utf-8")
    printed = cli("calibrate", record, "--out", tmp_path / "hand.json")[1]
    line = next(line for line in printed.splitlines() if line.startswith("softening"))
    assert "0 (held: the membrane was not conditioned)" in line


@pytest.mark.parametrize(
    ("spoil", "code", "said"),
    [
        (lambda text: text.replace("sphere", "cylinder"), 1, "no press of a hemisphere"),
        (lambda text: "".join(text.splitlines(True)[:4]), 1, "too few"),
        (lambda text: text.replace(",0.005,", ",nan,", 1), 2, "force_sd_N"),
        (lambda text: "stiffness,1\n", 2, "a table begins with"),
    ],
)
def test_a_table_that_carries_no_calibration_is_refused(cli, record, tmp_path, spoil, code, said):
    path = record / NAME
    path.write_text(spoil(path.read_text("utf-8")), "utf-8")
    ended, _, errors = cli("calibrate", record, "--out", tmp_path / "hand.json")
    assert ended == code
    assert said in errors
    assert not (tmp_path / "hand.json").exists()


def test_a_picture_is_of_the_presses_that_the_fit_used(cli, record, tmp_path):
    pytest.importorskip("matplotlib", reason="pictures need the extra 'plot'")
    path, row = record / NAME, "sphere,10,,60,14,"
    lines = path.read_text("utf-8").splitlines(True)
    rows = [line.replace("sphere,10,", "sphere,6,") for line in lines if line.startswith("sphere,10,")]
    lines = [line.replace(line.split(",")[6], "0") if line.startswith(row) else line for line in lines]
    path.write_text("".join(lines + rows), "utf-8")
    asked = ("calibrate", record, "--out", tmp_path / "hand.json", "--plot", tmp_path / "hand.svg", "--json")
    code, printed, errors = cli(*asked)
    assert code == 0, errors
    assert "6 mm" in json.loads(printed)["warnings"][0]
    assert "<svg" in (tmp_path / "hand.svg").read_text("utf-8")


@pytest.mark.parametrize("name", ["paper", "membrane"])
def test_a_shipped_model_predicts_by_its_name(cli, name):
    code, printed, _ = cli(
        "predict", "--calibration", name, "--radius", "12mm", "--stretch", "20mm", "--depth", "8mm", "--json"
    )
    assert code == 0
    assert json.loads(printed)["force_N"] == shipped(name).predict(0.012, 0.02, 0.008)[0]


@pytest.mark.parametrize("content", [None, "[" * 200_000, '{"format": 1}', "{", "\xff"])
def test_what_is_no_calibration_is_refused_at_once(cli, tmp_path, content):
    place = tmp_path / "hand.json"
    os.mkfifo(place) if content is None else place.write_text(content)
    code, _, told = cli("predict", "--calibration", place, "--radius", "12mm", "--stretch", "20mm", "--depth", "8mm")
    assert code == 2
    assert f"error: {place}: " in told
