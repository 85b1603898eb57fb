"""reconstruct in the twin: a cube by planned presses, by poses of the operator, and what it cannot press."""

import json
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.hardware.simulated.operator import SimulatedOperator
from stretch_bt.simulation.objects.base import Point

CUBE = """\
format: stretch-scene/1
object: {{type: box, length: 40 mm, width: 40 mm, height: 40 mm, edge: 1 mm, rigid: true, position: {{x: {x}, y: 0 mm}}}}
effects: none
dimensions: {{length: 40 mm, width: 40 mm, height: 40 mm}}
"""
#: where only the way that a run fails counts
BALL = """\
format: stretch-scene/1
object: {{type: sphere, diameter: 40 mm, rigid: true, position: {{x: {x}, y: 0 mm}}}}
fidelity: hertz
effects: none
"""
QUICK = {"frames": 2, "touch_frames": 2, "speed": 0.05}


@pytest.fixture
def reconstruct(run, hand_at, tmp_path):
    def make(x="3 mm", scene=CUBE, **params):
        path = tmp_path / "scene.yaml"
        path.write_text(scene.format(x=x))
        return run("reconstruct", cell=hand_at(60), scene=path, params={**QUICK, **params})

    return make


def commands(result, name):
    events = [json.loads(line) for line in (Path(result.record) / "events.jsonl").read_text().splitlines()]
    return [e["arguments"] for e in events if e["type"] == "command" and e["name"] == name]


def felt_beyond(path):
    """Return how far, mm, felt points lie outside the outline of the cube, for points that do, and their stated deviations, mm."""
    _, rows = path.read_bytes().split(b"end_header\n")
    rows = np.frombuffer(rows, "<f8, <f8, <f8, u1, u1, u1, <f4, <i4")
    x, y, _, *_, sd, seen = (rows[name] for name in rows.dtype.names)
    out = 1e3 * np.maximum(np.abs(x - 3e-3), np.abs(y)) - 20.0
    there = (seen > 0) & (out > 0.5)
    return out[there], 1e3 * sd[there]


def test_a_cube_is_covered_by_planned_presses(reconstruct):
    result = reconstruct(max_presses=4)
    assert result.status == "SUCCESS", result.reason
    out = {name: value["value"] for name, value in result.outputs.items()}
    assert out["coverage"] > 0.8
    assert 0.95 * 40**2 < out["felt"] < 44**2, "at most 2 mm beyond its edges"
    assert out["shape"] == "block"
    for side in ("length", "width", "height"):
        assert abs(out[side] - 40.0) < min(0.5, 3 * result.outputs[side]["sd"]), side
        assert result.truth[side]["value"] == pytest.approx(40.0)
    assert "radius" not in out, "a block has none"
    assert out["top"] == pytest.approx(40.0, abs=0.3)
    assert 2 <= out["presses"] <= 4
    assert out["pieces"] == 1
    assert out["limited"] < out["presses"]
    assert commands(result, "confirm") == []
    assert "the fitted block" in (Path(result.record) / "report.html").read_text()
    for name in ("cloud.ply", "cloud.png"):
        assert (Path(result.record) / name).stat().st_size > 1000
    beyond, sd = felt_beyond(Path(result.record) / "cloud.ply")
    assert len(beyond) > 20
    assert np.sqrt(np.mean((beyond / sd) ** 2)) < 2.0, "it is 9.8 over noise and floor alone"


@pytest.mark.slow
def test_poses_of_the_operator_are_confirmed_one_by_one_and_a_light_press_ends_by_its_force(reconstruct):
    result = reconstruct(poses=["3 mm; 0 mm", "3 mm; 0 mm; 90 deg"], max_force=0.8)
    assert result.status == "SUCCESS", result.reason
    assert (result.outputs["presses"]["value"], result.outputs["limited"]["value"]) == (2, 2)
    asked = [c["request"] for c in commands(result, "confirm")]
    assert len(asked) == 2
    assert "x 3 mm, y 0 mm, turned by 90 deg" in asked[1]


HARD = {
    "no contact at all": ({"x": "250 mm"}, "FAILURE", "nothing was met"),
    "an object outside the reach": (
        {"poses": ["3 mm; 0 mm", "700 mm; 0 mm"]},
        "FAILURE",
        "x 700 mm is past the limits of the cell",
    ),
    "a press that hits a limit": ({"max_force": 0.5, "max_presses": 1}, "SUCCESS", ""),
    "the first press beside the object": ({"poses": ["120 mm; 0 mm"]}, "FAILURE", "nothing was met"),
    "a later press beside the object": ({"poses": ["3 mm; 0 mm", "120 mm; 0 mm"]}, "SUCCESS", ""),
}


@pytest.mark.parametrize(("reached", "ended"), [("0.6 mm", "force"), ("0.9 mm", "deflection"), ("0.2 mm", "balance")])
def test_a_press_that_ended_at_once_shows_nothing_and_the_next_is_planned(run, reached, ended):
    text = (Path(__file__).parent / "mocks" / "reconstruct_success.yaml").read_text()
    for before, after in (
        ("reached: [15 mm, 9 mm], ended: [depth, force]", f"reached: [{reached}, 9 mm], ended: [{ended}, force]"),
        ('{match: "**/map_view", ', '{match: "**/views/**/map_view", status: [success, success, failure], '),
    ):
        assert before in text
        text = text.replace(before, after).partition("expect:")[0]
    first = """  - {match: "main/map_press/map_view", outputs: {relief: {}, cloud: {}, contacts: [[{}]]}}\nreadings:"""
    result = run("reconstruct", mocks=text.replace("readings:", first))
    assert (result.status, result.outputs["presses"]["value"]) == ("SUCCESS", 3), result.reason


#: in the default run
QUICK_ENDS = ("no contact at all", "an object outside the reach", "the first press beside the object")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK_ENDS)) for name in HARD]
)
def test_a_hard_case_ends_as_expected(reconstruct, name):
    given, status, reason = HARD[name]
    result = reconstruct(scene=CUBE if status == "SUCCESS" else BALL, **given)
    assert (result.status, reason in result.reason) == (status, True), result.reason
    limited = result.outputs.get("limited", {"value": 0})["value"]
    assert limited == (1 if name == "a press that hits a limit" else 0)
    if status == "SUCCESS":
        assert abs(result.outputs["height"]["value"] - 40.0) < 0.5


@pytest.mark.slow
def test_an_object_that_moved_between_presses_ends_the_run_and_is_not_averaged_in(reconstruct, monkeypatch):
    asked, confirm = [], SimulatedOperator.confirm

    def moving(operator, request):
        asked.append(request)
        if len(asked) == 3:
            twin = operator.cell.twin
            twin.exchange(twin.scene.object.model_copy(update={"position": Point(x="14 mm", y="0 mm")}))
        return confirm(operator, request)

    monkeypatch.setattr(SimulatedOperator, "confirm", moving)
    result = reconstruct(poses=["3 mm; 0 mm", "3 mm; 0 mm; 90 deg", "3 mm; 4 mm"])
    assert "x 3 mm, y 0 mm, turned by 90 deg" in asked[1]
    assert result.status == "FAILURE", result.reason
    assert "the object moved or gave way" in result.reason
    written = [json.loads(line) for line in (Path(result.record) / "events.jsonl").read_text().splitlines()]
    assert not [e for e in written if e["type"] == "write" and e["key"] == "main/shape"], "no shape of two places"
