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
