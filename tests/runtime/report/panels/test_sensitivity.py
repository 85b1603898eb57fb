"""The panel of contact sensitivity: a map for each quantity and method, and their numbers."""

import re
from itertools import product

import pytest

from stretch_bt.model.calibration.sensitivity import METHODS, NAME, Found, Sensed, first_lines, sensed_lines
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.report.heatmap import Map, Tile, heatmaps, tint
from stretch_bt.runtime.report.panels.sensitivity import panel

GRID = list(product((0.01, 0.02), (0.0, 0.03), (0.005, 0.01)))


def press(size, stretch, depth):
    """Return a press whose fit errs by 0.5 mm along i at 10 mm of depth and by 3 mm at 5 mm; the paper's are refused at 20 mm."""
    error = 3e-3 if depth < 0.006 else 5e-4
    refused = [Found(m, refused="<no contact>") for m in METHODS[1:]]
    wide = [Found(m, size + 3e-3, 0.0, size - 3e-3, 0.0) for m in METHODS[1:]]
    return Sensed(
        "cylinder",
        size,
        stretch,
        depth,
        1,
        (Found("fit", size + error, 1e-4, size, 1e-4), *(refused if size > 0.015 else wide)),
        0.0,
    )


@pytest.fixture
def record(tmp_path):
    def write(text):
        recorder = RunRecord(tmp_path / "record")
        recorder.start({"tree": "contact_sensitivity.yaml", "params": {}}, {})
        if text is not None:
            (tmp_path / "record" / NAME).write_text(text)
        recorder.close({"status": "SUCCESS", "reason": "", "outputs": {}, "truth": {}})
        return RecordReader(tmp_path / "record")

    return write


def table(grid=GRID):
    return first_lines({}) + "".join(sensed_lines(press(*place)) for place in grid)


def test_there_is_a_map_for_each_quantity_and_method(record):
    html = panel(record(table()))
    figures = re.findall(r"<figure>(.*?)</figure>", html, re.DOTALL)
    assert len(figures) == 9
    names = [re.search(r"<b>(.*?)</b>", figure).group(1).split(":")[0] for figure in figures]
    assert names == ["along i", "along j", "absolute"] * 3
    assert [figure.count("<rect") for figure in figures] == [len(GRID)] * 9
    # 3 mm along i and none along j are 1.5 mm in the mean
    assert [figure.count("stroke=") for figure in figures] == [0, 0, 4, 0, 0, 0, 0, 0, 0]
    assert figures[3].count('fill="#d4d8de"') == 4
    assert "10 mm, stretch 30 mm, depth 5 mm\nerror 3 mm" in figures[0]
    assert "20 mm, stretch 0 mm, depth 10 mm\nrefused 1 of 1" in figures[8]


def test_the_numbers_stand_beside_them(record):
    html = panel(record(table()))
    ours, *theirs = re.findall(r"<tr><td>(.*?)</tr>", html)
    assert "50% of 8" in ours
    assert "0 of 8" in ours
    assert all("0% of 8" in row and "4 of 8" in row for row in theirs)
    cells = re.findall(r'<td class="n">(.*?)</td>', ours)
    assert cells[2] == "0.88 ± 0.24"
    assert cells[3].startswith("−1; −0.25")
    assert cells[4:] == ["–", "–"]


@pytest.mark.parametrize(("depths", "head"), [((0.001, 0.002), "2 mm"), ((0.002, 0.005), "5 mm"), ((0.01,), "5 mm")])
def test_the_mean_is_headed_by_the_depth_from_which_it_is(record, depths, head):
    html = panel(record(table(list(product((0.01,), (0.0,), depths)))))
    assert f">mean error from {head}, mm<" in html


def test_a_trend_of_one_group_has_no_standard_error(record):
    html = panel(record(table([(0.01, 0.0, 0.005), (0.01, 0.0, 0.01)])))
    ours = re.findall(r"<tr><td>(.*?)</tr>", html)[0]
    assert re.findall(r'<td class="n">(.*?)</td>', ours)[3:] == ["−1; −0.25", "–", "–"]


@pytest.mark.parametrize("text", [None, first_lines({})])
def test_without_a_press_there_is_no_panel(record, text):
    assert panel(record(text)) == ""


@pytest.mark.parametrize(
    ("text", "told"),
    [(table()[:-9], "the last press is not whole"), (table() + "20,10\r,5\n", "27: a carriage return stands within")],
)
def test_a_table_that_cannot_be_read_is_told(record, text, told):
    assert told in panel(record(text))


def test_colours_say_sign_and_size():
    assert tint(0.0) == "#fafaf8"
    assert tint(-1.0) == tint(-9.0) == "#2166ac"
    assert tint(1.0) == tint(5.0) == "#b2182b"
    reds = [int(tint(k / 10)[3:5], 16) for k in range(11)]
    assert reds == sorted(reds, reverse=True)


def test_tiles_lie_where_their_places_are_in_order():
    html = heatmaps("a < b", "x", "y", [Map("m", [Tile(x, y, 0.0) for x in (3.0, 1.0) for y in (2.0, 1.0)])], 1.0)
    assert "a &lt; b" in html
    corners = [tuple(map(float, c)) for c in re.findall(r'<rect x="(.*?)" y="(.*?)"', html)]
    (x3, y2), (_, y1), (x1, _), _ = corners
    assert x1 < x3
    assert y1 < y2
