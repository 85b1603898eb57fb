"""The panel of a cloud."""

import base64

import numpy as np

from stretch_bt.perception import cloud_of
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.report.panels.cloud import panel


def record(folder):
    recorder = RunRecord(folder)
    recorder.start({"tree": "reconstruct.yaml", "params": {}}, {})
    recorder.close({"status": "SUCCESS", "reason": "", "outputs": {}, "truth": {}})
    return RecordReader(folder)


def test_a_saved_cloud_is_shown_within_the_page(tmp_path):
    made = record(tmp_path / "record")
    assert panel(made) == ""
    cloud_of(np.random.default_rng(0).normal(size=(50, 3)) * 0.01, 1e-4).save(tmp_path / "record" / "cloud.png")
    shown = panel(made)
    assert base64.b64encode((tmp_path / "record" / "cloud.png").read_bytes()).decode() in shown
    assert "<h2>Cloud" in shown
