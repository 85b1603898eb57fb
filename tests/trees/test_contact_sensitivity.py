"""contact_sensitivity in the twin: what it finds of a cylinder, and an interruption costs nothing but time."""

import json
from pathlib import Path

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.sensitivity import METHODS, NAME, read_sensitivity
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.replay import replay

SCENE = """\
format: stretch-scene/1
object: {type: cylinder, diameter: 20 mm, height: 60 mm, rigid: true}
effects: {sag: off, bending: on, friction: off, white_noise: on, correlated_noise: on, fixed_pattern: on, drift: off, dropout: on}
"""
#: the same where only the way that a run ends counts
BRIEF = SCENE.partition("effects:")[0] + "fidelity: hertz\n"
SMALL = {"clearance": 0.01, "diameters": [0.02], "stretches": [0.03], "depths": [0.0, 0.006], "frames": 8}


@pytest.fixture
def sensitivity(run, hand_at, tmp_path):
    def make(scene=SCENE, **options):
        path = tmp_path / "scene.yaml"
        path.write_text(scene)
        params = {**SMALL, **options.pop("params", {})}
        return run("contact_sensitivity", cell=hand_at(65), scene=path, params=params, **options)

    return make


def table_of(result):
    return read_sensitivity(Path(result.record) / NAME).rows


def commands(result, name):
    lines = (Path(result.record) / "events.jsonl").read_text().splitlines()
    return [e["arguments"] for e in map(json.loads, lines) if e["type"] == "command" and e["name"] == name]


def interrupted_after_a_row(runner):
    class Ends(Onlooker):
        def write(self, key, value, sd, path):
            if (key, value) == ("main/presses", 1):
                runner.interrupt("SIGINT")

    runner.watchers.append(Ends())


def test_a_cylinder_is_felt_to_a_millimetre_and_an_interrupted_map_is_gone_on_with(sensitivity, tmp_path):
    path = tmp_path / "table.csv"
    first = sensitivity(params={"table": str(path)}, watch=interrupted_after_a_row)
    assert first.status == "INTERRUPTED"
    measured = len(read_sensitivity(path).rows)
    assert measured == 1
    with path.open("a") as file:
        file.write("20,30,10,1,fit,circle,20.1\n20,30")
    second = sensitivity(params={"table": str(path)})
    assert second.status == "SUCCESS", second.reason
    out = second.outputs
    assert (out["rows"]["value"], out["presses"]["value"]) == (2, 2 - measured)
    rows = table_of(second)
    assert [press.depth for press in rows] == pytest.approx(SMALL["depths"], abs=1e-9)
    assert {(press.geometry, press.size) for press in rows} == {("cylinder", 0.02)}
    # at first touch there is nothing to see, and each way says so
    assert [found.method for found in rows[0].found] == list(METHODS)
    assert any(found.refused for found in rows[0].found)
    assert all(found.i == found.j == 0.0 for found in rows[0].found if found.refused)
    ours = [press.of("fit") for press in rows[1:]]
    assert all(abs(found.i - 0.02) < 1e-3 and abs(found.j - 0.02) < 1.5e-3 for found in ours), ours
    assert all(0 < found.i_sd < 1.5e-3 for found in ours)  # the edge's radius, which no frame shows, is 1 ± 0.58 mm
    # the paper's segmentation takes in much of the skirt
    assert 0 < out["error"]["value"] < 1.0 < out["error_paper_width"]["value"]
    assert out["error"]["unit"] == "mm"
    assert out["robot_time"]["value"] == pytest.approx(second.task_seconds, abs=2)
    assert [c["size"] for c in commands(second, "mount")] == [0.02]
    assert replay(second.record).identical
    third = sensitivity(params={"table": str(path)})
    assert (third.status, third.outputs["presses"]["value"], commands(third, "mount")) == ("SUCCESS", 0, [])
    assert "<h2>Contact sensitivity</h2>" in (Path(third.record) / "report.html").read_text()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"stretches": ["200 mm"]}, "stretches: 200 mm .* 0 mm to 80 mm"),
        ({"diameters": ["2 mm"]}, "no cylinder of 2 mm"),
        ({"table": "none/table.csv"}, "there is no folder none"),
    ],
)
def test_what_no_run_can_reach_ends_before_anything_moves(sensitivity, tmp_path, wrong, said):
    record = tmp_path / "record"
    with pytest.raises(InvalidInput, match=said):
        sensitivity(params=wrong, out=record)
    assert not record.exists()


def test_too_much_force_ends_the_task_and_raises_the_hand(sensitivity):
    runners = []
    result = sensitivity(BRIEF, params={"max_force": 0.3}, watch=runners.append)
    assert result.status == "FAILURE"
    assert "0.3 N" in result.reason
    assert runners[0].cell.truth()["force"] == 0.0
