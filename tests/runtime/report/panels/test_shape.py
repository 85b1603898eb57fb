"""The panel of a fitted shape: what was felt, what was fitted, and what the scene has there."""

import re

import numpy as np
import pytest

from stretch_bt.perception import Dimension, Solid, cloud_of
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.report.panels.shape import panel
from stretch_bt.simulation.scene import scene_text

MM = 1e-3
SHAPES = {
    "block": ({"length": 40 * MM, "width": 30 * MM}, (40, 30)),
    "disc": ({"radius": 15 * MM}, (30, 30)),
    "half_cylinder": ({"length": 50 * MM, "radius": 20 * MM}, (50, 40)),
    "ridge": ({"length": 50 * MM}, (50, 0.4)),
    "wire_triangle": ({"side": 50 * MM}, (43.3, 50)),
}


@pytest.fixture
def record(tmp_path):
    def write(kind, sizes, scene=None, cloud=True, heading=0.0, told_as=lambda solid: solid, **told):
        recorder = RunRecord(tmp_path / "record")
        recorder.start({"tree": "reconstruct.yaml", "params": {}}, {"scene": scene, **told})
        recorder.begin_tick(1, 0.05)
        dimensions = {name: Dimension(value, 1e-4, {}) for name, value in {**sizes, "height": 20 * MM}.items()}
        solid = Solid(kind, dimensions, 0.01, 0.0, 20 * MM, heading, ())
        recorder.write("main/solid", told_as(solid), None, "main/fit_object")
        recorder.close({"status": "SUCCESS", "reason": "", "outputs": {}, "truth": {}})
        if cloud:
            cloud_of(np.random.default_rng(0).normal(size=(50, 3)) * 0.005, 1e-4).save(
                tmp_path / "record" / "cloud.ply"
            )
        return RecordReader(tmp_path / "record")

    return write


def extents(drawing, colour):
    """Return how wide and how high the lines of a colour are, mm."""
    mm = float(re.search(r'h([\d.]+)" stroke="#333"', drawing)[1]) / 10
    paths = re.findall(rf'd="M([^"]+)" fill="none" style="stroke:{colour}', drawing)
    places = np.array([[float(v) for v in pair.split()] for path in paths for pair in path.split("L")])
    return np.ptp(places, axis=0) / mm


@pytest.mark.parametrize("kind", SHAPES)
def test_a_shape_is_drawn_in_its_size(record, kind):
    sizes, expected = SHAPES[kind]
    drawn = panel(record(kind, sizes))
    assert f"the fitted {kind.replace('_', ' ')}" in drawn
    assert extents(drawn, "#2155a0") == pytest.approx(expected, abs=0.3)


def test_a_shape_is_drawn_as_it_is_turned(record):
    drawn = panel(record("block", SHAPES["block"][0], heading=-np.pi / 2))
    assert extents(drawn, "#2155a0") == pytest.approx((30, 40), abs=0.3)


OTHERS = {
    "an older record": lambda solid: {"kind": solid.kind, "dimensions": {}, "middle": solid.middle, "heading": 0.0},
    "a mock": lambda solid: {"kind": solid.kind, "x": None, "y": None, "dimensions": None},
    "another task": lambda solid: 1.0,
}


@pytest.mark.parametrize("told_as", OTHERS.values(), ids=OTHERS)
def test_a_shape_that_stands_nowhere_is_not_drawn(record, told_as):
    assert panel(record("block", SHAPES["block"][0], told_as=told_as)) == ""


def test_the_truth_of_the_scene_is_drawn_under_it(record):
    drawn = panel(record("block", SHAPES["block"][0], scene="wooden_cube"))
    assert extents(drawn, "#2a8f4d") == pytest.approx((39.4, 39.4), abs=1.2), "its edges are round"


@pytest.mark.parametrize(("simulated", "drawn"), [(["Arm", "DepthCamera"], True), (["Arm"], False)])
def test_the_scene_is_drawn_only_where_a_simulated_camera_looked(record, simulated, drawn):
    found = panel(record("block", SHAPES["block"][0], scene="wooden_cube", simulated=simulated))
    assert ("#2a8f4d;" in found) is drawn


def test_without_a_cloud_or_a_scene_less_is_drawn(record):
    assert panel(record("block", SHAPES["block"][0], cloud=False)) == ""


def test_a_scene_that_is_gone_leaves_the_fit(record):
    assert "#2a8f4d" not in panel(record("block", SHAPES["block"][0], scene="gone.yaml"))


@pytest.mark.parametrize(
    "now", ["", "format: stretch-scene/1\nobject: {type: box, length: 90 mm, width: 90 mm, height: 9 mm}\n"]
)
def test_the_scene_is_that_of_the_run_whatever_its_file_holds_now(record, tmp_path, now):
    (tmp_path / "own.yaml").write_text(now)
    told = {"scene": str(tmp_path / "own.yaml"), "scene_text": scene_text("wooden_cube")}
    drawn = panel(record("block", SHAPES["block"][0], **told))
    assert extents(drawn, "#2a8f4d") == pytest.approx((39.4, 39.4), abs=1.2)
