"""The panel of a cookie, from what a record holds of it."""

import math

import pytest

from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.report.panels.cookie import panel
from stretch_bt.runtime.sketches import SKETCHES, Sketches

CIRCLE = [(0.015 * math.cos(k / 5), 0.015 * math.sin(k / 5)) for k in range(31)]


def record(folder, sketches=None, circularity=0.97128, keys=(), sd=None):
    recorder = RunRecord(folder)
    recorder.start({"tree": "form_cookie.yaml", "params": {}}, {})
    for k in range(4):
        recorder.begin_tick(k, float(k))
        recorder.write("main/before", 0.030 + 0.001 * k, None, "main/track_height")
        recorder.write("main/watch_height/force_success/read_height/spread", 0.001, None, "main/height_settled")
    recorder.write("main/sense/line", [v for point in CIRCLE for v in point], None, "main/measure_outline")
    for name, value in keys:
        recorder.write(f"main/own/{name}", value, sd, "main/own")
    if sketches is not None:
        sketches.save(folder)
    outputs = {"circularity_true": {"value": circularity, "unit": "", "sd": None}}
    recorder.close({"status": "SUCCESS", "reason": "", "outputs": outputs, "truth": {}})
    return RecordReader(folder)


def drawn(times, lines):
    sketches = Sketches({"main/rolling_time": "rolling_time"}, lambda: lines)
    for time in times:
        sketches.begin_tick(0, time)
        sketches.write("main/rolling_time", time, None, "main/set")
        sketches.write("main/rolling_time", time, None, "main/set")
        sketches.write("main/height", time, None, "main/set")
    return sketches


def test_it_shows_shapes_outlines_and_every_circularity(tmp_path):
    sketches = drawn([0.0, 0.5, 1.0, 3.0, 3.5], {"side": CIRCLE, "outline": CIRCLE})
    assert [time for time, _ in sketches.kept] == [0.0, 3.0]
    shown = panel(record(tmp_path / "record", sketches))
    for text in (
        "before, 0 s",
        "after, 3.5 s",
        "true",
        "sensed",
        "height of the top",
        "how far from a ball",
        "0.9713",
        "circularity_true",
    ):
        assert text in shown, text
    assert "nan" not in shown.lower()


def test_a_spread_that_is_not_known_yet_is_not_drawn(tmp_path):
    sketches = drawn([0.0, 3.0], {"side": CIRCLE, "outline": CIRCLE})
    unknown = record(tmp_path / "record", sketches, keys=[("spread", 0.1)], sd=0.1)
    assert panel(unknown) == panel(record(tmp_path / "without", sketches))


NOT_OURS = [{"a": 1}, "text", True, math.nan, [0.1, "a"], [0.1, math.inf], [0.1, 0.2, 0.3], [], [[0.1, 0.2]]]


@pytest.mark.parametrize("value", NOT_OURS, ids=str)
def test_a_key_of_the_same_name_and_another_kind_is_left_out(tmp_path, value):
    keys = [(name, value) for name in ("before", "line", "spread", "residual", "width")]
    sketches = drawn([0.0, 3.0], {"side": CIRCLE, "outline": CIRCLE})
    assert panel(record(tmp_path / "record", sketches, keys=keys)) == panel(record(tmp_path / "without", sketches))


def test_nothing_is_shown_of_what_keeps_its_shape(tmp_path):
    made = record(tmp_path / "record", drawn([0.0, 3.0], {}))
    assert not (made.folder / SKETCHES).exists()
    assert panel(made) == ""


def test_an_output_that_is_markup_is_shown_as_text(tmp_path):
    shown = panel(record(tmp_path / "record", drawn([0.0, 3.0], {"side": CIRCLE, "outline": CIRCLE}), "<b>1</b>"))
    assert "&lt;b&gt;1&lt;/b&gt;" in shown
    assert "<b>1</b>" not in shown
