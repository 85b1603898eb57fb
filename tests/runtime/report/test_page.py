import re
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from stretch_bt.errors import RecordError, StaleReading
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.runtime.record import RunRecord
from stretch_bt.runtime.report import write_report
from stretch_bt.runtime.report.history import Frames, Series
from stretch_bt.runtime.report.pictures import pictures
from stretch_bt.runtime.report.plot import plot
from stretch_bt.runtime.report.timeline import timeline

HEADER = {"tree": {"name": "press<b>"}, "scene": "water_balloon", "seed": 3, "keys": {"depth": "Length"}}
RESULT = {
    "status": "SUCCESS",
    "reason": "",
    "ticks": 40,
    "task_seconds": 2.0,
    "outputs": {
        "stiffness": {"value": 0.4123, "unit": "N/mm", "sd": 0.0123},
        "force": {"value": -1.5, "unit": "N", "sd": None},
        "presses": {"value": 7, "unit": "", "sd": None},
    },
    "truth": {"stiffness": {"value": 0.4, "unit": "N/mm", "sd": None}},
}
VOID = {"meta", "br", "img"}


@dataclass
class Ball:
    radius: float
    radius_sd: float


class Page(HTMLParser):
    """Checks that every element closes, and keeps text, attributes and the text of table rows."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.tags: list[str] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self.feed(path.read_text(encoding="utf-8"))
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


def recorded(folder: Path, result: dict[str, Any] | None = None) -> Path:
    record = RunRecord(folder)
    record.start(HEADER, {"host": "lab-3"})
    intrinsics = Intrinsics(50.0, 50.0, 16.0, 12.0, 32, 24)
    for tick in range(1, 41):
        record.begin_tick(tick, tick / 20)
        raw = np.full((24, 32), 1600 - tick, np.uint16)
        record.reading("camera", "frame", Reading(DepthFrame(raw, 1.25e-4, intrinsics, 0.0, tick), 0.0, 0.0, tick))
        record.reading("arm", "pose", Reading(Pose((0.0, 0.0, 0.3)), tick / 20, tick / 20, tick))
        record.reading("arm", "wrench", Reading(Wrench((0.0, 3.0, 4.0)), tick / 20, tick / 20, tick))
        record.write("depth", tick / 1000, 1e-4, "main/press")
        record.write("ball", Ball(0.02, 0.001), None, "main/fit")
    record.status("main/press", "RUNNING", "to 10 mm")
    record.command("arm", "move", {"target": Pose((0.0, 0.0, 0.25)), "speed": 0.01}, "main/press")
    record.status("main/press", "FAILURE", "the cap is <too> small")
    record.status("main", "FAILURE", "main/press")
    record.fault("camera", StaleReading("camera", "the frame is old"))
    record.note("stop", status="FAILURE")
    record.close(RESULT if result is None else result)
    return folder


def test_a_page_that_needs_nothing_else(tmp_path: Path) -> None:
    path = write_report(recorded(tmp_path / "r"))
    assert path == tmp_path / "r/report.html"
    page = Page(path)
    assert not {"script", "link", "iframe"} & set(page.tags)
    sources = [value for name, value in page.attributes if name in ("src", "href", "srcset")]
    assert len(sources) == 2
    assert all(value is not None and value.startswith("data:image/png;base64,") for value in sources)
    assert "url(" not in path.read_text(encoding="utf-8")


def test_outputs_stand_beside_the_truth(tmp_path: Path) -> None:
    page = Page(write_report(recorded(tmp_path / "r")))
    start = page.rows.index(["output", "value", "unit", "truth", "error", "relative error", "error in sd"])
    assert page.rows[start + 1 : start + 4] == [
        ["stiffness", "0.412 ± 0.012", "N/mm", "0.4", "+0.012", "+3.1%", "+1.0"],
        ["force", "−1.5", "N", "", "", "", ""],
        ["presses", "7", "", "", "", "", ""],
    ]
    assert "Last readings" not in page.text


def test_without_truth_there_are_no_columns_for_it(tmp_path: Path) -> None:
    page = Page(write_report(recorded(tmp_path / "r", {**RESULT, "truth": {}})))
    assert ["output", "value", "unit"] in page.rows


def test_a_failure_shows_node_reason_and_readings(tmp_path: Path) -> None:
    result = {"status": "FAILURE", "reason": "main/press: the cap is <too> small", "outputs": {}, "truth": {}}
    page = Page(write_report(recorded(tmp_path / "r", result)))
    assert "main/press at 2.0 s: the cap is <too> small".replace("2.0", "2") in page.text
    assert ["arm", "pose", "(0, 0, 300) mm, rotation (0, 0, 0) rad", "2", "40"] in page.rows
    assert ["camera", "frame", "32 × 24 depth frame 40", "0", "40"] in page.rows
    assert ["2", "fault", "camera StaleReading: the frame is old"] in page.rows
    assert ["2", "stop", "status FAILURE"] in page.rows
    command = ["2", "arm.move", "speed 0.01target position (0, 0, 0.25), rotation (0, 0, 0)", "main/press"]
    assert command in page.rows


def test_every_scalar_is_plotted_in_its_unit(tmp_path: Path) -> None:
    page = Page(write_report(recorded(tmp_path / "r")))
    for caption in ("depth mm40 mm", "ball.radius SI0.02", "arm.pose.height mm300 mm", "arm.wrench.force N5 N"):
        assert caption in page.text
    assert "ball.radius_sd" not in page.text


def test_a_record_that_was_not_closed(tmp_path: Path) -> None:
    record = RunRecord(tmp_path / "r")
    record.start(HEADER, {})
    for tick in range(3):
        record.begin_tick(tick, tick / 20)
        record.status("main", "RUNNING", f"{tick}")
    page = Page(write_report(tmp_path / "r", tmp_path / "elsewhere.html"))
    record.close({})
    assert "UNFINISHED" in page.text
    assert "the record ends early, at 0.05 s" in page.text


def test_an_empty_run_still_has_a_page(tmp_path: Path) -> None:
    record = RunRecord(tmp_path / "r")
    record.start({}, {})
    record.close({"status": "ERROR", "reason": "the camera is not there"})
    assert "the camera is not there" in Page(write_report(tmp_path / "r")).text


def test_where_no_report_can_be(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="no such folder"):
        write_report(tmp_path / "nowhere")
    with pytest.raises(RecordError, match="cannot write the report"):
        write_report(recorded(tmp_path / "r"), tmp_path / "no/such/place.html")
    with pytest.raises(RecordError, match=r"write a name such as page\.html"):
        write_report(tmp_path / "r", tmp_path / "page.pdf")
    assert write_report(tmp_path / "r", tmp_path / "page.HTML").is_file()


def places(drawing: str, kind: str) -> list[tuple[float, float]]:
    found = re.findall(rf'<{kind} [^>]*?c?x="([-\d.]+)" c?y="([-\d.]+)"', drawing)
    return [(float(x), float(y)) for x, y in found]


def test_points_lie_where_their_values_are() -> None:
    drawing = plot(Series("x", None, [(0.0, 1.0, None), (5.0, 2.0, None), (10.0, 4.0, None)]), 0.0, 10.0)
    (x0, y0), (x1, y1), (x2, y2) = places(drawing, "circle")
    assert x1 - x0 == pytest.approx(x2 - x1, abs=0.2)
    assert (y1 - y2) / (y0 - y1) == pytest.approx(2.0, abs=0.02)


def test_a_long_series_keeps_its_extremes_and_stays_small() -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(size=50_000)
    values[31_234] = 40.0
    points = [(i / 1000, float(v), None) for i, v in enumerate(values)]
    alone = plot(Series("x", None, [points[31_234]]), 0.0, 50.0)
    drawing = plot(Series("x", None, points), 0.0, 50.0)
    assert len(drawing) < 60_000
    x, _ = places(alone, "circle")[0]
    top = min(float(y) for y in re.findall(r"V([\d.]+)", drawing.partition('class="l"')[2]))
    assert f"H{x:.1f}V{top:.1f}" in drawing


def test_rows_follow_the_tree_with_parents_first() -> None:
    drawing = timeline({"main/b/x": [], "main/a": [], "main": [], "main/b": []}, 0.0, 1.0)
    assert re.findall(r"<title>(.*?)</title>", drawing) == ["main", "main/b", "main/b/x", "main/a"]
    assert timeline({}, 0.0, 1.0) == ""


def test_pictures_show_near_bright_and_invalid_grey() -> None:
    raw = np.tile(np.arange(1000, 1100, dtype=np.uint16), (80, 1))
    raw[:10] = 0
    frame = DepthFrame(raw, 1e-3, Intrinsics(1.0, 1.0, 0.0, 0.0, 100, 80), 0.0, 0)
    content = re.findall(r"base64,([^\"]+)", pictures({"camera": Frames((0.0, frame), (1.0, frame))}))
    assert len(content) == 2
    import base64

    image = cv2.imdecode(np.frombuffer(base64.b64decode(content[0]), np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (80, 100, 3)
    assert (image[:10] == 160).all()
    assert int(image[40, 5].sum()) > int(image[40, 95].sum())


def test_a_camera_that_saw_nothing() -> None:
    frame = DepthFrame(np.zeros((4, 4), np.uint16), 1e-3, Intrinsics(1.0, 1.0, 0.0, 0.0, 4, 4), 0.0, 0)
    assert "0.0% valid" in pictures({"camera": Frames((0.0, frame), (1.0, frame))})


MARKUP = "<script>alert(1)</script>"


@pytest.mark.parametrize(
    ("device_time", "sequence", "value"),
    [(0.05, MARKUP, 2.0), ([MARKUP], 1, 2.0), (0.05, [MARKUP], True), (0.05, 1, MARKUP)],
)
def test_no_reading_of_a_record_becomes_markup(tmp_path: Path, device_time: Any, sequence: Any, value: Any) -> None:
    record = RunRecord(tmp_path / "r")
    record.start(HEADER, {})
    record.begin_tick(1, 0.05)
    record.reading("own", "value", Reading(value, device_time, 0.05, sequence))
    record.close({"status": "FAILURE", "reason": ""})
    page = Page(write_report(tmp_path / "r"))
    assert "script" not in page.tags
    assert MARKUP in page.text
