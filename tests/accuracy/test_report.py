"""Rows of a domain as a table, a picture, files and a page."""

import csv
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.accuracy import Domain, Kind, Row, Setting, domains, file, page
from stretch_bt.accuracy.advice import NOT_MEASURED, DomainSummaries
from stretch_bt.accuracy.folder import write
from stretch_bt.accuracy.job import CPU_MS, PRESSES, ROBOT_S, Panel
from stretch_bt.accuracy.picture import draw
from stretch_bt.accuracy.points import Cost
from stretch_bt.accuracy.summary import MANY, summarise
from stretch_bt.accuracy.table import table
from stretch_bt.errors import InvalidInput

SVG = "{http://www.w3.org/2000/svg}"
KINDS = {"force": Kind("%", 100.0), "surface": Kind("um", 1e6, "m")}
PANELS = (Panel("force", CPU_MS), Panel("surface", CPU_MS))
DOMAIN = Domain(
    "against what", KINDS, PANELS, lambda found: "So take it.", {}, lambda: None, lambda quick: [], frozenset({"peer"})
)


def row(case, series, error, seconds=0.01, **given):
    setting = Setting(*(part.strip() for part in f"{series}:".split(":")[:2]))
    fixed = {
        "default": False,
        "seed": None,
        "error_kind": "force",
        "unit": "1",
        "reference_error": None,
        "robot_seconds": None,
    }
    fixed |= {
        "cost": None,
        "status": "ok",
        "reason": None,
        "cpu": "a <processor>",
        "commit": "abc",
        "versions": {"python": "3"},
    }
    return Row(domain="membrane", case=case, setting=setting, error=error, cpu_seconds=seconds, **fixed | given)


ROWS = [
    row("a", "reference: fine", 1e-4, 1.0, status="reference", reference_error=1e-4),
    *(
        row(f"case {k}", "sheet: coarse", k * 1e-3, k * 1e-3, default=True, reference_error=1e-4)
        for k in range(1, MANY + 1)
    ),
    *(row(f"case {k}", "sheet: fine", k * 1e-4, k * 1e-2, reference_error=1e-4) for k in range(1, 12)),
    row("case 1", "sheet: coarse", 2e-5, 1e-3, error_kind="surface", unit="m", default=True),
    row("case 12", "sheet: fine", None, 0.2, status="refused", reason="NoEquilibrium: it slid off"),
    row("a", "peer: as it comes", 0.3, 0.5),
    row("a", "absent peer", None, None, status="skipped", reason="install it"),
]


def test_unknown_domains_are_named_with_the_nearest():
    assert "membrane" in domains()
    assert list(domains(["membrane", "membrane"])) == ["membrane"]
    with pytest.raises(InvalidInput, match=r"'membrain'; the domains are .*membrane.*did you mean 'membrane'"):
        domains(["membrain"])


def test_a_summary_counts_a_case_once():
    reference, coarse, fine, peer, absent = summarise(ROWS)
    assert (coarse.answered, coarse.default, len(fine.unanswered)) == (MANY, True, 1)
    assert coarse.costs(CPU_MS.of).median == pytest.approx(10.5)
    force = np.arange(1, MANY + 1) * 1e-3
    assert coarse.errors("force").end == pytest.approx(np.percentile(force, 95))
    assert fine.errors("force").end == pytest.approx(0.0011)
    assert (coarse.errors("force").end_name, fine.errors("force").end_name) == ("95th percentile", "largest of 11")
    assert reference.is_reference
    assert (absent.answered, absent.costs(CPU_MS.of), len(absent.skipped)) == (0, None, 1)
    assert peer.errors("surface") is None


def test_variants_of_a_series_stand_together():
    rows = [row("a", name, 0.1) for name in ("one: 8", "two", "one: 4")]
    assert [str(s.setting) for s in summarise(rows)] == ["one: 8", "one: 4", "two"]


def test_the_table_states_the_reference_first_and_every_failure():
    text = table("membrane", DOMAIN, ROWS)
    lines = text.splitlines()
    assert lines[:2] == ["membrane", "against what"]
    line = next(line for line in lines if line.startswith("sheet: coarse (default)"))
    assert line.split()[3:5] == [str(MANY), "0"]
    assert "1 / 1.9 / 2" in line
    assert "  sheet: fine: case 12: refused: NoEquilibrium: it slid off" in lines
    assert "  absent peer: a: skipped: install it" in lines
    assert text.index("reference: fine") < text.index("sheet: coarse")


def words_of(picture):
    return [e.text for e in picture.iter(f"{SVG}text")]


def test_the_picture_names_the_default_the_points_the_failures_and_the_reference():
    picture = ET.fromstring(draw("membrane", DOMAIN, ROWS))
    words = words_of(picture)
    assert {
        "error of the force, %",
        "error of the surface, um",
        "CPU ms",
        "default: coarse",
        "fine",
        "peer: as it comes",
    } <= set(words)
    assert any(text.endswith(": 1 of 12") for text in words)
    assert "the reference's own error" in words
    assert "absent peer" not in words
    rings = [e for e in picture.iter(f"{SVG}circle") if e.get("class") == "r"]
    assert len(rings) == 3  # two panels, and what the ring means
    hollow = [e for e in picture.iter(f"{SVG}circle") if e.get("fill") == "#fff"]
    assert len(hollow) == 2
    assert len([e for e in picture.iter(f"{SVG}rect") if e.get("width") == "8"]) == 2  # the peer, and in the legend
    empty = ET.fromstring(draw("membrane", DOMAIN, []))
    assert [e for e in empty.iter(f"{SVG}circle") if e.get("class") == "r"][1:] == []


def test_bars_end_flat_at_a_percentile_and_pointed_at_the_largest():
    bars = [e.get("d") for e in ET.fromstring(draw("membrane", DOMAIN, ROWS)).iter(f"{SVG}path") if "V" in e.get("d")]
    bars = [d for d in bars if re.search(r"h8$|l4 -4l4 4$", d)]
    assert [bool(d.endswith("h8")) for d in bars] == [True, False, True, False]  # coarse, fine, and the legend


def test_labels_hide_neither_each_other_nor_a_point():
    rows = [row("a", f"s{k}: variant {k}", 1e-3 * (1 + 0.05 * k), 0.01 * (1 + 0.05 * k)) for k in range(9)]
    picture = ET.fromstring(draw("membrane", replace(DOMAIN, panels=PANELS[:1]), rows))
    boxes = []
    for e in picture.iter(f"{SVG}text"):
        if (e.text or "").startswith("variant"):
            x, y, wide = float(e.get("x")), float(e.get("y")), 6.1 * len(e.text)
            left = x - {"e": wide, "m": wide / 2}.get((e.get("class") or "").split()[-1], 0.0)
            boxes.append((left, y - 10, left + wide, y + 3))
    assert len(boxes) == 9
    for k, a in enumerate(boxes):
        for b in boxes[:k]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


@pytest.mark.parametrize(("axis", "name"), [(ROBOT_S, "robot s"), (PRESSES, "presses")])
def test_other_costs_are_drawn_where_a_panel_asks_for_them(axis, name):
    rows = [
        row(f"case {k}", f"a: {k}", k * 1e-2, 9.0, robot_seconds=10.0 * k, cost=Cost("presses", 2 * k))
        for k in (1, 2, 3)
    ]
    domain = replace(DOMAIN, panels=(Panel("force", axis),))
    words = words_of(ET.fromstring(draw("membrane", domain, rows)))
    assert name in words
    assert "CPU ms" not in words
    head = table("membrane", DOMAIN, rows).splitlines()[3]
    assert head.split()[:7] == ["setting", "cases", "failed", "robot", "s", "CPU", "ms"]
    assert "robot s" not in table("membrane", DOMAIN, ROWS)


def test_what_to_take_is_in_the_rows():
    found = DomainSummaries(DOMAIN, ROWS)
    assert (
        found.default("force", CPU_MS) == "**sheet: coarse** (1 % off in the median, 1.9 % 95th percentile, 10 CPU ms)"
    )
    assert found.cheapest("force", CPU_MS, 0.02).startswith("**sheet: coarse**")
    assert found.cheapest("force", CPU_MS, 0.0012) == NOT_MEASURED  # the fine one has no answer for one case
    whole = DomainSummaries(DOMAIN, [r for r in ROWS if r.status != "refused"])
    assert whole.cheapest("force", CPU_MS, 0.0012).startswith("**sheet: fine** (0.06 % off")
    assert whole.cheapest("force", CPU_MS, 1e-5) == NOT_MEASURED
    assert found.setting(Setting("sheet", "none"), "force", CPU_MS) == NOT_MEASURED
    assert (
        found.setting(Setting("peer", "as it comes"), "force", CPU_MS) == "**peer: as it comes** (30 % off, 500 CPU ms)"
    )


def test_files_hold_every_row(tmp_path):
    rows = [replace(r, domain="membrane") for r in ROWS] + [row("b", "x", 0.1, cost=Cost("presses", 3.0), seed=2)]
    write(tmp_path, rows)
    assert {p.name for p in tmp_path.iterdir()} == {"accuracy.jsonl", "accuracy.csv", "membrane.svg"}
    assert file.read(tmp_path / "accuracy.jsonl") == rows
    with (tmp_path / "accuracy.csv").open(newline="") as opened:
        found = list(csv.DictReader(opened))
    assert [r["error"] for r in found] == ["" if r.error is None else str(r.error) for r in rows]
    assert found[0]["versions"] == "python=3"


def test_nothing_measured_is_still_a_file(tmp_path):
    write(tmp_path, [])
    assert file.read(tmp_path / "accuracy.jsonl") == []


GOOD = '{"format": "stretch-accuracy/2"}\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "cannot be read: No such file"),
        ("", r"rows.jsonl:1: .* no line of JSON"),
        ('{"format": "stretch-accuracy/1"}\n', r"rows.jsonl:1: .*begins with"),
        (GOOD + "[1]\n", r"rows.jsonl:2: a row is a JSON object"),
        (GOOD + '{"domain": "membrane"}\n', r"rows.jsonl:2: the row has no 'case'"),
        (GOOD + '{"domain": "membrain", *}\n', r"rows.jsonl:2: there is no accuracy domain 'membrain'"),
        (GOOD + '{"status": "fine", *}\n', r"rows.jsonl:2: a status is one of ok, "),
        (GOOD + '{"setting": "fine", *}\n', r"rows.jsonl:2: a setting has series and variant"),
        (GOOD + '{"cost": 3, *}\n', r"rows.jsonl:2: a cost is null or has name"),
        (GOOD + '{"error": "much", *}\n', r"rows.jsonl:2: error is a number or null"),
        (GOOD + '{"wight": 1, *}\n', r"rows.jsonl:2: a row has no 'wight'"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_line(tmp_path, text, says):
    path = tmp_path / "rows.jsonl"
    if text is not None:
        good = row("a", "b", 0.1).to_json()
        if "*" in text:
            import json

            head, line = text.split("\n", 1)
            text = head + "\n" + json.dumps(good | json.loads(line.replace(", *", ""))) + "\n"
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput, match=says):
        file.read(path)


def test_the_last_row_of_a_key_counts():
    old, new = row("a", "b", 0.1), row("a", "b", 0.2)
    other = row("a", "c", 0.3)
    assert file.merged([old, other, new]) == [new, other]


def test_a_page_is_drawn_from_its_own_rows(tmp_path):
    page.write(tmp_path, ROWS)
    text = (tmp_path / page.INDEX).read_text(encoding="utf-8")
    assert "## membrane" in text
    assert "![membrane: error by cost](membrane.svg)" in text
    assert "- absent peer: not run, install it" in text
    assert page.kept(tmp_path) == ROWS


COMMITTED = Path(__file__).parents[2] / "docs" / "accuracy"


def test_the_committed_page_is_that_of_its_rows(tmp_path):
    rows = page.kept(COMMITTED)
    page.write(tmp_path, file.merged(rows))
    assert {p.name for p in COMMITTED.iterdir()} == {p.name for p in tmp_path.iterdir()}
    for path in COMMITTED.iterdir():
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name
    assert sum(p.stat().st_size for p in COMMITTED.glob("*.jsonl")) < 2_000_000
