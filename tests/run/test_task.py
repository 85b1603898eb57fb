"""What a run refuses before anything begins."""

import pytest

from stretch_bt.errors import SceneError
from stretch_bt.run.task import run


def test_a_scene_that_does_not_exist_is_refused_also_where_nothing_is_simulated(tmp_path):
    (tmp_path / "tree.yaml").write_text("format: stretch-tree/1\ntrees: {main: {wait: {duration: 0 s}}}\n")
    with pytest.raises(SceneError, match="no shipped scene"):
        run(tmp_path / "tree.yaml", scene="nosuch", out=tmp_path / "record")
    assert not (tmp_path / "record").exists()
