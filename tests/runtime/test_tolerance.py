"""A run that asks for a tolerance: what it records, and where it has none."""

import json

import pytest

import stretch_bt
from stretch_bt.errors import InvalidInput
from stretch_bt.runtime.replay import replay

TREE = """\
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera}
trees:
  main:
    sequence:
      - average_frames: {count: 2}
"""
SCENE = """\
format: stretch-scene/1
object: {type: sphere, diameter: 40 mm, stiffness: 0.9 N/mm, base: 20 mm}
tolerance: {height: 0.3 mm, stiffness: 5 %}
fidelity: auto
"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "look.yaml").write_text(TREE)
    (tmp_path / "ball.yaml").write_text(SCENE)
    return {"tree": tmp_path / "look.yaml", "scene": tmp_path / "ball.yaml"}


def told(record, name):
    return json.loads((record / name).read_text())


def test_it_is_recorded_reported_and_replayed(files, tmp_path):
    found = stretch_bt.run(**files, out=tmp_path / "record", tolerance={"stiffness": "2 %"})
    assert found.status == "SUCCESS"
    record = tmp_path / "record"
    info, header = told(record, "run.json"), json.loads((record / "events.jsonl").read_text().splitlines()[0])
    assert info["tolerance"] == header["tolerance"] == info["choice"]["asked"] == {"stiffness": 0.02}
    assert info["choice"] == told(record, "result.json")["choice"] == found.choice
    assert set(info["choice"]["on"]) == set(info["effects"])
    assert info["choice"]["predicted"].keys() == {"height", "stiffness"}
    page = (record / "report.html").read_text()
    assert "predicted height" in page
    assert "of 2 %" in page
    again = replay(record)
    assert again.identical
    assert again.same


def test_a_run_without_one_says_what_the_scene_chose(files, tmp_path):
    found = stretch_bt.run(**files, out=tmp_path / "record")
    info, header = told(tmp_path / "record", "run.json"), (tmp_path / "record" / "events.jsonl").read_text()
    assert info["tolerance"] is None
    assert "tolerance" not in json.loads(header.splitlines()[0])
    assert found.choice["asked"] == {}
    assert found.choice["reached"]


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"mocks": {"format": "stretch-mocks/1", "nodes": [{"match": "**"}]}}, "a run on mocks is none"),
        ({"devices": {}}, "devices that are open already have theirs"),
        ({"cell": "lab_ur5", "scene": None}, "nothing is simulated in this run; leave out --tolerance"),
        ({"tolerance": {"stiffness": "0.001 %"}}, "the best that can be had is stiffness"),
        ({"tolerance": {"stifness": "2 %"}}, "did you mean 'stiffness'?"),
    ],
)
def test_where_there_is_none_it_is_refused_before_anything_is_opened(files, tmp_path, how, says):
    options = {**files, "tolerance": {"stiffness": "2 %"}, **how}
    with pytest.raises(InvalidInput) as refused:
        stretch_bt.run(**options, out=tmp_path / "record")
    assert says in str(refused.value)
    assert not (tmp_path / "record").exists()


def test_an_open_cell_has_its_scene(files):
    with (
        stretch_bt.open_cell(scene=files["scene"]) as cell,
        pytest.raises(InvalidInput, match="devices that are open already have theirs"),
    ):
        stretch_bt.run(files["tree"], cell=cell, tolerance={"stiffness": "2 %"})
