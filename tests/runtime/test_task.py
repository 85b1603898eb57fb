"""What a run refuses before anything begins."""

import inspect
import pkgutil
from importlib import import_module

import pytest

import stretch_bt
import stretch_bt.runtime
from stretch_bt.errors import SceneError
from stretch_bt.runtime.task import run


def test_a_scene_that_does_not_exist_is_refused_also_where_nothing_is_simulated(tmp_path):
    (tmp_path / "tree.yaml").write_text("format: stretch-tree/1\ntrees: {main: {wait: {duration: 0 s}}}\n")
    with pytest.raises(SceneError, match="no shipped scene"):
        run(tmp_path / "tree.yaml", scene="nosuch", out=tmp_path / "record")
    assert not (tmp_path / "record").exists()


def test_run_is_a_function_whatever_was_imported_before():
    for module in pkgutil.iter_modules(stretch_bt.runtime.__path__, "stretch_bt.runtime."):
        import_module(module.name)
    assert inspect.isfunction(stretch_bt.run)
    assert {"tree", "scene", "cell", "params", "seed", "mocks", "out", "devices"} <= {
        *inspect.signature(stretch_bt.run).parameters
    }


PRESS = """
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
trees:
  main:
    out: [height]
    sequence:
      - set_stretch: {stretch: 10 mm}
      - capture: {frame}
      - set: {height: arm.height, size: 2 mm, size_sd: 1 mm, late: task.time}
      - check: size + height + 0 * late * 1 mm/s > 0 mm
"""


def test_a_result_has_what_a_test_asks_for(tmp_path):
    (tmp_path / "press.yaml").write_text(PRESS)
    result = run(tmp_path / "press.yaml", scene="water_balloon", out=tmp_path / "record")
    assert result.status == "SUCCESS", result.reason
    assert result.visited["main/capture"][-1] == "SUCCESS"
    assert result.visited["main/set_stretch"] == ("RUNNING", "SUCCESS")
    [(time, device, name, arguments, owner)] = result.commands
    assert (device, name, owner) == ("gripper", "move", "main/set_stretch")
    assert 0.0 <= time < result.task_seconds
    assert arguments["opening"] > 0
    assert result.keys["frame"].stretch == pytest.approx(0.010, abs=5e-4)
    assert (float(result.keys["size"]), result.keys["size"].sd) == (0.002, 0.001)
    assert result.readings["arm.pose"]["position"][2] == pytest.approx(result.keys["height"])
    assert not {"visited", "commands", "keys"} & result.to_json().keys()
