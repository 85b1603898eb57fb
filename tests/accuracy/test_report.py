"""Domains by name, and rows as a table, a picture and files."""

import csv
import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from stretch_bt.accuracy import Kind, Row, domains
from stretch_bt.accuracy.folder import write
from stretch_bt.accuracy.picture import draw
from stretch_bt.accuracy.summary import summarise
from stretch_bt.accuracy.table import table
from stretch_bt.errors import InvalidInput

KINDS = {"force": Kind("%", 100.0), "surface": Kind("um", 1e6)}


def row(case, setting, error, seconds=0.01, status="ok", kind="force", robot=None):
    return Row("membrane", case, setting, None, error, kind, seconds, status, {"python": "3"}, "a <processor>", robot)


ROWS = [
    row("a", "reference: fine", 1e-4, 1.0, "reference"),
    *(row(f"case {k}", "sheet: coarse", k * 1e-3, k * 1e-3) for k in range(1, 12)),
    row("case 1", "sheet: coarse", 2e-5, 1e-3, kind="surface"),
    row("case 12", "sheet: coarse", None, 0.2, "no_equilibrium: it slid off"),
    row("a", "peer", None, None, "skipped: install it"),
]


def test_unknown_domains_are_named_with_the_nearest():
    assert "membrane" in domains()
    assert list(domains(["membrane", "membrane"])) == ["membrane"]
    with pytest.raises(InvalidInput, match=r"'membrain'; the domains are .*membrane.*did you mean 'membrane'"):
        domains(["membrain"])


def test_a_summary_counts_a_case_once():
    reference, coarse, peer = summarise(ROWS)
    assert (coarse.answered, len(coarse.unanswered), coarse.series, coarse.variant) == (11, 1, "sheet", "coarse")
    assert coarse.seconds.median == pytest.approx(0.006)
    force = np.arange(1, 12) * 1e-3
    assert coarse.errors["force"].p95 == pytest.approx(np.percentile(force, 95))
    assert coarse.errors["force"].largest == pytest.approx(0.011)
    assert reference.is_reference
    assert (peer.answered, peer.seconds, peer.errors) == (0, None, {})


def test_variants_of_a_series_stand_together():
    rows = [row("a", name, 0.1) for name in ("one: 8", "two", "one: 4")]
    assert [s.setting for s in summarise(rows)] == ["one: 8", "one: 4", "two"]


def test_the_table_states_the_reference_first_and_every_failure():
    text = table("membrane", "against what", KINDS, ROWS)
    lines = text.splitlines()
    assert lines[:2] == ["membrane", "against what"]
    assert next(line for line in lines if line.startswith("reference: fine")).split()[-6:] == [
        *["0.01", "/", "0.01", "/", "0.01", "-"]
    ]
    line = next(line for line in lines if line.startswith("sheet: coarse"))
    assert line.split()[2:4] == ["11", "1"]
    assert "0.6 / 1 / 1.1" in line
    assert "  sheet: coarse: case 12: no_equilibrium: it slid off" in lines
    assert "  peer: a: skipped: install it" in lines
    assert text.index("reference: fine") < text.index("sheet: coarse")


def test_the_picture_is_xml_with_a_panel_a_kind_and_each_series_by_name():
    picture = ET.fromstring(draw("membrane", KINDS, ROWS))
    words = [e.text for e in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert {"force", "surface", "sheet", "median error, %", "median error, um"} <= set(words)
    assert "peer" not in words
    empty = ET.fromstring(draw("membrane", KINDS, []))
    assert list(empty.iter("{http://www.w3.org/2000/svg}circle")) == []


def test_where_a_robot_takes_time_that_is_the_cost():
    rows = [row(f"case {k}", f"a: {k}", k * 1e-2, 9.0, robot=10.0 * k) for k in (1, 2, 3)]
    text = table("palpation", "against what", KINDS, rows)
    head, spread, line = text.splitlines()[3:6]
    assert head.split()[:7] == ["setting", "cases", "failed", "robot", "s", "CPU", "ms"]
    assert spread.split()[:6] == ["median", "/", "p95"] * 2
    assert line.split()[:9] == ["a:", "1", "1", "0", "10", "/", "10", "9000", "/"]
    assert "robot s" not in table("membrane", "against what", KINDS, ROWS)
    picture = draw("palpation", KINDS, rows)
    assert "robot s" in picture
    assert "CPU ms" not in picture
    places = {float(y) for y in re.findall(r'<circle cx="[^"]*" cy="([^"]*)" r="3.5" fill="[^"]*"><title>', picture)}
    assert len(places) == 3
    assert [("robot_seconds" in r.to_json()) for r in (rows[0], ROWS[0])] == [True, False]


@pytest.mark.parametrize(
    ("costs", "marks"),
    [
        ([12.0, 40.0], ["10", "20", "50"]),
        ([0.011], ["0.01", "0.02"]),
        ([1.0, 3e4], ["1", "10", "100", "1000", "10000", "100000"]),
    ],
)
def test_an_axis_is_marked_from_below_the_least_to_above_the_largest(costs, marks):
    rows = [row(f"case {k}", f"a: {k}", 0.01, robot=cost) for k, cost in enumerate(costs)]
    picture = draw("palpation", {"force": Kind("%", 100.0)}, rows)
    assert re.findall(r'<text class="e"[^>]*>([^<]*)</text>', picture) == marks


def test_files_hold_every_row(tmp_path):
    write(tmp_path, ROWS)
    assert {p.name for p in tmp_path.iterdir()} == {"accuracy.json", "accuracy.csv", "membrane.svg"}
    assert json.loads((tmp_path / "accuracy.json").read_text()) == [r.to_json() for r in ROWS]
    with (tmp_path / "accuracy.csv").open(newline="") as file:
        table_rows = list(csv.DictReader(file))
    assert [r["error"] for r in table_rows] == ["" if r.error is None else str(r.error) for r in ROWS]
    assert table_rows[0]["versions"] == "python=3"


def test_nothing_measured_is_still_a_file(tmp_path):
    write(tmp_path, [])
    assert json.loads((tmp_path / "accuracy.json").read_text()) == []
