"""The panel of palpation: what it draws of a record, and of one that ends early."""

import os
import re

import numpy as np
import pytest

import stretch_bt
from stretch_bt.model.force.force_model import ForceModel, shipped
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.report.panels.looks import read_looks
from stretch_bt.runtime.report.panels.palpation import panel

RADIUS, TOP, POWER, STIFF = 0.03, 0.06, 1.5, 2.5e4
#: stretch, depth of the membrane, m; the second and the third are looks at one press
PRESSES = [(0.0, 0.009), (0.0, 0.014), (0.0, 0.01404), (0.02, 0.0142)]
PARAMS = {"model": "paper", "drop": 1.5e-3}


def given_way(force):
    """Return the drop of an object whose force is STIFF times its drop to a power."""
    return (force / STIFF) ** (1 / POWER)


@pytest.fixture
def record(tmp_path):
    """Write a record of looks at an object that the force law presses, as a palpation does."""

    def write(presses=PRESSES, params=PARAMS, run_info=None, radius=RADIUS, done=True, **result):
        recorder = RunRecord(tmp_path / "record")
        recorder.start({"tree": "palpate.yaml", "params": params}, run_info or {})
        recorder.begin_tick(1, 0.05)
        recorder.write("main/sphere", {"radius": radius, "radius_sd": 1e-3}, None, "main/fit_sphere")
        force = drop = 0.0
        for tick, (stretch, depth) in enumerate(presses, 2):
            recorder.begin_tick(tick, tick / 20)
            force = shipped("paper").predict(RADIUS, stretch, depth)[0]
            drop = given_way(force)
            last = {"stretch": stretch, "depth": depth, "height": TOP - drop, "sd": 5e-5}
            felt = {"deflection": drop, "deflection_sd": 1e-4, "force": force, "force_sd": 0.05 * force, "last": last}
            recorder.write("main/felt", felt, None, "main/feel/fit_deflection")
        if done:
            at = STIFF * PARAMS["drop"] ** (POWER - 1)
            recorder.write("main/stiffness_at_drop", at, 10.0, "main/stiffness_at")
        recorder.close({"status": "SUCCESS", "reason": "", "outputs": {}, "truth": {}, **result})
        return RecordReader(tmp_path / "record")

    return write


def figures(html):
    """Return what each figure shows: names in its legend, its lines, its marks as (x, y), its numbers."""
    return [
        {
            "names": re.findall(r"</i>(.*?)</span>", text),
            "lines": [
                [tuple(map(float, place.split())) for place in path.split("L")]
                for path in re.findall(r'<path class="l" style="[^"]*" d="M([^"HV]*)"', text)
            ],
            "marks": [tuple(map(float, m)) for m in re.findall(r'<circle class="d" cx="(.*?)" cy="(.*?)"', text)],
            "numbers": re.findall(r'<text x="[^4][^"]*" y="[^"]*">(\d+)</text>', text),
        }
        for text in re.findall(r"<figure>(.*?)</figure>", html, re.DOTALL)
    ]


def off(mark, line):
    """Return by how many pixels a mark is off a line, up or down."""
    (x, y), right = mark, next(k for k, place in enumerate(line) if place[0] >= mark[0])
    (x0, y0), (x1, y1) = line[right - 1 : right + 1]
    return abs(y0 + (y1 - y0) * (x - x0) / (x1 - x0) - y)


def test_presses_lie_on_the_curves_of_their_stretches_and_on_that_of_the_object(record):
    path, body = figures(panel(record()))
    assert path["names"] == ["0 mm", "20 mm"]
    slack, taut, way = path["lines"]
    assert max(off(mark, slack) for mark in path["marks"][:3]) < 1.0
    assert off(path["marks"][3], taut) < 1.0 < off(path["marks"][3], slack)
    assert way == path["marks"]
    assert path["numbers"] == body["numbers"] == ["1", "2", "3"]
    assert body["names"] == ["fitted to all looks"]
    assert max(off(mark, body["lines"][0]) for mark in body["marks"]) < 1.0


def test_of_many_presses_the_first_and_the_last_are_numbered(record):
    many = [(0.0, 0.005 + 0.0005 * k) for k in range(20)]
    path, _ = figures(panel(record(many)))
    assert path["numbers"] == ["1", "20"]
    assert len(path["marks"]) == 20


def test_every_look_has_its_errors_and_says_where_it_was(record):
    html = panel(record())
    assert html.count("<title>") == 2 * len(PRESSES)
    assert "stretch 20 mm\ndepth 14.2 mm, force" in html
    bars = re.findall(r'stroke-width:1" d="M([\d.]+) ([\d.]+)H([\d.]+)M[\d.]+ ([\d.]+)V([\d.]+)"', html)
    assert len(bars) == 2 * len(PRESSES)
    assert all(float(left) < float(right) and float(low) > float(high) for left, _, right, low, high in bars)


@pytest.mark.parametrize(("force", "drop"), [((1.2, "N"), (1.3, "mm")), ((1200, "mN"), (1300.0, "um"))])
def test_the_scene_knows_the_last_press(record, force, drop):
    truth = {name: {"value": v, "unit": unit} for name, (v, unit) in (("force", force), ("deflection", drop))}
    _, body = figures(panel(record(truth=truth)))
    assert body["names"][1] == "ring: the last press, by the scene"
    *looks, ring = body["marks"]
    assert len(looks) == len(PRESSES)
    forces = [shipped("paper").predict(RADIUS, *press)[0] for press in PRESSES]
    drops = [1e3 * given_way(f) for f in forces]
    for place, known, true in ((0, drops, 1.3), (1, forces, 1.2)):
        a, b = np.polyfit(known, [look[place] for look in looks], 1)
        assert ring[place] == pytest.approx(a * true + b, abs=0.2)


@pytest.mark.parametrize("drop", [{}, {"value": None, "unit": "mm"}, {"value": 1.3, "unit": "parsec"}, {"value": 1.3}])
def test_without_a_drop_that_the_scene_knows_there_is_no_ring(record, drop):
    _, body = figures(panel(record(truth={"force": {"value": 1.2, "unit": "N"}, "deflection": drop})))
    assert len(body["marks"]) == len(PRESSES)


@pytest.mark.parametrize("presses", [[], PRESSES[:1]])
def test_a_run_that_ended_early_shows_what_there_is(record, presses):
    html = panel(record(presses, done=False, status="FAILURE", reason="main/press: too soft"))
    if not presses:
        assert html == ""
        return
    path, body = figures(html)
    assert (path["names"], len(path["marks"])) == (["0 mm"], 1)
    assert (body["names"], len(body["marks"])) == ([], 1)


def test_looks_that_are_not_numbers_or_not_whole_are_left_out(record):
    events = record().events
    lost = [e for e in events if e["type"] != "write" or e["key"] != "main/sphere"]
    assert read_looks(lost) == []
    for event in events:
        if event["type"] == "write" and event["key"] == "main/felt" and event["tick"] == 3:
            event["value"]["force"] = "NaN"
    assert [look.time for look in read_looks(events)] == [0.1, 0.2, 0.25]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"params": {"drop": 1.5e-3}}, "no param 'model' that names it"),
        ({"params": {**PARAMS, "model": "hand.json"}}, "hand.json: the calibration cannot be read"),
        (
            {"params": {**PARAMS, "model": "hand.json"}, "run_info": {"set": {"model": "far/hand.json"}}},
            "far/hand.json:",
        ),
        ({"radius": 0.5}, "radius 500 mm is outside the calibrated range"),
    ],
)
def test_without_the_model_the_path_stands_alone_and_the_page_says_so(record, tmp_path, monkeypatch, change, reason):
    monkeypatch.chdir(tmp_path)
    html = panel(record(**change))
    assert "without the curves of the force model: " in html
    assert reason in html.replace("&#x27;", "'")
    path, _ = figures(html)
    assert path["names"] == ["0 mm", "20 mm"]
    assert len(path["lines"]) == 1
    assert len(path["marks"]) == len(PRESSES)


def test_the_model_that_the_run_fitted_is_read_from_its_record(record, tmp_path):
    params = {**PARAMS, "model": "fitted"}
    assert "calibration.json: the calibration cannot be read" in panel(record(params=params))
    shipped("paper").save(tmp_path / "record" / "calibration.json")
    html = panel(RecordReader(tmp_path / "record"))
    assert "curves: the force model that this run fitted" in html
    assert len(figures(html)[0]["lines"]) == 3


def test_a_model_file_that_changed_since_is_told(record, tmp_path):
    file = tmp_path / "hand.json"
    shipped("paper").save(file)
    os.utime(file, (1e9, 1e9))
    info = {"set": {"model": str(file)}, "started": "2020-01-01T00:00:00+00:00"}
    html = panel(record(run_info=info))
    assert "curves: hand.json<" in html
    os.utime(file)
    assert "curves: hand.json, which was written again after the run began" in panel(RecordReader(tmp_path / "record"))


@pytest.mark.parametrize("tree", [pytest.param("palpate_stiffness", marks=pytest.mark.slow), "palpate_active"])
def test_a_palpation_in_the_twin_has_its_panel(at_hertz, hand_at, tmp_path, tree):
    scene = at_hertz("seeds_balloon", tmp_path)
    ForceModel.default().save(tmp_path / "hand.json")
    params = {
        "model": str(tmp_path / "hand.json"),
        "touches": 2,
        "touch_frames": 4,
        "sensing_frames": 4,
        "min_hold": 0.0,
        "settle": 0.0,
    }
    result = stretch_bt.run(tree, cell=hand_at(75), scene=scene, params=params, out=tmp_path / "record")
    html = (tmp_path / "record" / "report.html").read_text("utf-8")
    assert html.index("<h2>Palpation</h2>") < html.index("<h2>Nodes over time</h2>")
    path, body = figures(panel(RecordReader(tmp_path / "record")))
    assert len(path["numbers"]) == result.outputs["presses"]["value"]
    assert "curves: hand.json" in html
    assert [len(path["lines"]), body["names"]] == [
        len(path["names"]) + 1,
        ["fitted to all looks", "ring: the last press, by the scene"],
    ]
