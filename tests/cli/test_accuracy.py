"""The command accuracy, on a domain that is quick to measure."""

import json
import re
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from stretch_bt.accuracy import Answer, Domain, Job, Kind, Setting, measure, measuring, registry
from stretch_bt.accuracy.compare import Comparison
from stretch_bt.accuracy.file import read
from stretch_bt.accuracy.job import CPU_MS, Panel
from stretch_bt.cli.app import main
from stretch_bt.errors import NoEquilibrium

FIELDS = [
    *("domain", "case", "setting", "default", "seed", "error", "error_kind", "unit", "reference_error", "cpu_seconds"),
    *("robot_seconds", "cost", "status", "reason", "cpu", "commit", "versions", "kernel_seconds"),
]


class Bench:
    """A domain whose answers are set by hand, and how often each was asked for."""

    def __init__(self):
        self.warmed, self.asked, self.error, self.seconds = 0, [], 0.02, [0.001]

    def domain(self):
        kinds = {"force": Kind("%", 100.0)}
        panels = (Panel("force", CPU_MS),)
        return Domain("against nothing", kinds, panels, lambda found: "So take it.", {}, self.warm, self.jobs)

    def warm(self):
        self.warmed += 1
        print("what another program prints")  # noqa: T201

    def jobs(self, quick):
        yield Job("a press", Setting("solver", "coarse"), "force", 0.001, lambda: self.answers("coarse"), default=True)
        yield Job("a press", Setting("solver", "lost"), "force", 0.001, self.lost, group="lost")
        yield Job(
            "a press", Setting("solver", "beside it"), "force", 0.001, lambda: self.answers("beside"), group="lost"
        )
        yield Job("a press", Setting("solver", "fine"), "force", 9.0, lambda: self.answers("fine"), seed=3)

    def answers(self, name):
        assert self.warmed
        self.asked.append(name)
        seconds = self.seconds[min(len(self.asked), len(self.seconds)) - 1]
        return [Answer("force", self.error, seconds, 0.001)]

    def lost(self):
        raise NoEquilibrium("it slid off")


@pytest.fixture
def bench(monkeypatch):
    found = Bench()
    monkeypatch.setattr(registry, "import_module", lambda name: SimpleNamespace(DOMAIN=found.domain()))
    return found


@pytest.fixture
def cli(tmp_path, monkeypatch, capfd, bench):
    """Run the command in an empty folder: (exit code, standard output, standard error)."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["stretch-bt", "accuracy", *arguments])
        with pytest.raises(SystemExit) as exited:
            main()
        return exited.value.code or 0, *capfd.readouterr()

    return call


def test_rows_are_the_contract(cli, bench):
    code, out, _ = cli("membrane", "--json")
    rows = json.loads(out)
    assert code == 0
    assert [list(row) for row in rows] == [FIELDS] * 3
    assert [row["seed"] for row in rows] == [None, None, 3]
    assert [row["default"] for row in rows] == [True, False, False]
    assert [row["status"] for row in rows] == ["ok", "refused", "ok"]
    assert rows[1]["reason"] == "NoEquilibrium: it slid off"
    assert bench.asked == ["coarse", "fine"]  # jobs that need the lost one are not tried
    for row in rows:
        assert (row["domain"], row["unit"]) == ("membrane", "1")
        assert row["setting"].keys() == {"series", "variant"}
        assert row["versions"].keys() == {"stretch-bt", "numpy", "scipy", "numba", "python"}
        assert row["cpu"]


def test_quick_skips_what_does_not_fit_and_no_name_is_all(cli):
    rows = json.loads(cli("membrane", "--quick", "--json")[1])
    assert [(row["status"], row["reason"]) for row in rows][-1] == ("skipped", "quick")
    assert [row["status"] for row in rows[:2]] == ["ok", "refused"]
    assert {row["domain"] for row in json.loads(cli("--quick", "--json")[1])} == set(registry.names())


def test_the_table_is_for_people(cli):
    code, out, _ = cli("membrane")
    assert code == 0
    assert "against nothing" in out
    assert "what another program prints" not in out
    assert "solver: fine" in out


def test_out_holds_the_rows_and_must_be_empty(cli, tmp_path):
    code, out, _ = cli("membrane", "--json", "--out", "figures")
    assert code == 0
    kept = tmp_path / "figures" / "accuracy.jsonl"
    assert kept.read_text().splitlines()[0] == '{"format":"stretch-accuracy/2"}'
    assert [row.to_json() for row in read(kept)] == json.loads(out)
    before = kept.stat().st_mtime_ns
    code, _, err = cli("membrane", "--out", "figures")
    assert code == 2
    assert "record-not-empty" in err
    assert kept.stat().st_mtime_ns == before


def test_rows_of_files_are_shown_without_measuring(cli, bench):
    _, out, _ = cli("membrane", "--json", "--out", "figures")
    bench.asked.clear()
    code, again, _ = cli("--from", "figures/accuracy.jsonl", "--json")
    assert (code, json.loads(again)) == (0, json.loads(out))
    code, _, err = cli("--from", "figures/accuracy.jsonl", "--quick")
    assert code == 2
    assert "--quick says what is measured" in err
    assert bench.asked == []


def test_a_page_keeps_the_domains_that_are_not_measured_again(cli, tmp_path):
    assert cli("membrane", "--page", "page")[0] == 0
    before = (tmp_path / "page" / "membrane.jsonl").read_bytes()
    assert cli("force", "--page", "page")[0] == 0
    assert {p.name for p in (tmp_path / "page").iterdir()} == {
        *("index.md", "membrane.svg", "membrane.jsonl", "force.svg", "force.jsonl")
    }
    assert (tmp_path / "page" / "membrane.jsonl").read_bytes() == before
    text = (tmp_path / "page" / "index.md").read_bytes()
    assert cli("--from", "page/membrane.jsonl", "page/force.jsonl", "--page", "again")[0] == 0
    assert (tmp_path / "again" / "index.md").read_bytes() == text


@pytest.mark.parametrize(
    ("error", "flag"),
    [(0.02, None), (0.0209, None), (0.022, "error 0.022 1, before 0.02"), (0.01, None)],
)
def test_a_worse_error_is_flagged(cli, bench, error, flag):
    cli("membrane", "--out", "old")
    bench.error = error
    code, out, _ = cli("membrane", "--json", "--compare", "old/accuracy.jsonl")
    assert code == (1 if flag else 0)
    assert {row["worse"] for row in json.loads(out) if row["status"] == "ok"} == {flag}


def test_what_shares_no_row_is_not_compared(cli, bench, tmp_path):
    """Nothing was compared, and 0 of all rows were worse: a check that cannot fail."""
    cli("membrane", "--out", "old")
    rows = Path("old/accuracy.jsonl").read_text().splitlines()
    Path("other.jsonl").write_text(
        "\n".join([rows[0], *(row.replace('"case":"', '"case":"another ') for row in rows[1:])])
    )
    code, _, err = cli("membrane", "--compare", "other.jsonl")
    assert (code, "nothing was compared" in err) == (2, True)
    code, _, err = cli("force", "--from", "old/accuracy.jsonl")
    assert (code, "there is no row of force" in err) == (2, True)


def test_what_was_skipped_is_not_compared(cli, bench):
    """A quick measurement of a slow domain compared nothing, and said that 0 of all rows were worse."""
    cli("membrane", "--out", "old")
    assert (
        "0 of 2 rows that were there before are worse"
        in cli("membrane", "--quick", "--compare", "old/accuracy.jsonl")[1]
    )
    bench.jobs = lambda quick: [Job("a press", Setting("solver", "fine"), "force", 9.0, list, seed=3)]
    code, _, err = cli("membrane", "--quick", "--compare", "old/accuracy.jsonl")
    assert (code, "nothing was compared" in err) == (2, True)


def test_the_last_row_of_a_key_counts_in_several_files(cli, bench):
    """The page held one row, and what was printed and kept beside it both."""
    cli("membrane", "--out", "old")
    bench.error = 0.5
    cli("membrane", "--out", "new")
    _, out, _ = cli("--from", "old/accuracy.jsonl", "--from", "new/accuracy.jsonl", "--page", "page", "--json")
    assert [row["error"] for row in json.loads(out)] == [0.5, None, 0.5]
    assert [row.to_json() | {"worse": None} for row in read(Path("page/membrane.jsonl"))] == [
        row | {"worse": None} for row in json.loads(out)
    ]


def test_a_page_that_cannot_be_kept_is_refused_before_anything_is_measured(cli, bench):
    """All that was measured was lost."""
    cli("membrane", "--page", "page")
    Path("page/membrane.jsonl").write_text("torn")
    bench.asked.clear()
    code, _, err = cli("force", "--page", "page")
    assert (code, "membrane.jsonl:1" in err, bench.asked) == (2, True, [])
    assert cli("membrane", "--page", "page")[0] == 0  # which it is to take the place of
    assert len(read(Path("page/membrane.jsonl"))) == 3


@pytest.mark.parametrize("number", ["NaN", "Infinity"])
def test_a_row_with_what_is_no_number_is_told_at_its_line(cli, bench, number):
    cli("membrane", "--out", "old")
    path = Path("old/accuracy.jsonl")
    path.write_text(re.sub(r'"error":[0-9.e-]+', f'"error":{number}', path.read_text(), count=1))
    code, _, err = cli("--from", str(path), "--json")
    assert code == 2
    assert f"accuracy.jsonl:2: this is no line of JSON: {number} is no number" in err


def test_what_has_no_answer_any_more_is_flagged(cli, bench, monkeypatch):
    cli("membrane", "--out", "old")
    monkeypatch.setattr(bench, "answers", lambda name: bench.lost())
    code, out, _ = cli("membrane", "--compare", "old/accuracy.jsonl")
    assert code == 1
    assert "2 of 3 rows that were there before are worse" in out
    assert "refused now, ok before: NoEquilibrium: it slid off" in out


def test_a_time_is_taken_again_before_it_is_called_slow(bench, monkeypatch):
    monkeypatch.setattr(measuring, "yardstick", lambda: 0.01)
    bench.seconds = [1.0]
    old = Comparison(list(measure(["membrane"])))
    assert bench.asked == ["coarse"] * 3 + ["fine"] * 3  # the least of three
    for seconds, slow in (([1.4], False), ([2.0], True), ([2.0, 2.0, 1.2], False)):
        bench.asked.clear()
        bench.seconds = seconds
        row = next(measure(["membrane"], doubt=old.slower))
        assert old.slower(row) is slow
        assert row.cpu_seconds == min(seconds)


def test_an_answer_that_is_kept_is_asked_for_once_and_its_time_not_compared(bench, monkeypatch):
    """Its first time stood beside the slowest of three times of the fixed computation."""
    bench.seconds = [1.0]
    plain = bench.jobs
    bench.jobs = lambda quick: [replace(job, once=True) for job in plain(quick)]
    row = next(measure(["membrane"], doubt=lambda row: True))
    assert (bench.asked, row.cpu_seconds, row.kernel_seconds) == (["coarse"], 1.0, None)


def test_a_long_job_is_run_once_unless_in_doubt(bench, monkeypatch):
    monkeypatch.setattr(measuring, "_LONG", 0.0)
    bench.seconds = [1.0]
    next(measure(["membrane"]))
    assert bench.asked == ["coarse"]
    next(measure(["membrane"], doubt=lambda row: True))
    assert bench.asked == ["coarse"] * 4


def test_parts_are_the_whole_and_keep_groups_together(bench):
    whole = [row.key for row in measure(["membrane"])]
    parts = [[row.key for row in measure(["membrane"], part=(k, 3))] for k in (1, 2, 3)]
    assert [key for part in parts for key in part] == whole
    assert len(parts[0]) < len(whole)


def test_quick_holds_to_its_time_where_jobs_take_longer_than_they_should(bench, monkeypatch):
    monkeypatch.setattr("stretch_bt.accuracy.budget.QUICK", 3.0)

    def slow():
        began = time.process_time()
        while time.process_time() < began + 0.05:
            pass
        return [Answer("force", 0.1, 0.01)]

    bench.jobs = lambda quick: [Job(f"{k}", Setting("a", ""), "force", 0.0001, slow) for k in range(2000)]
    rows = list(measure(["membrane"], quick=True))
    spent = sum(row.status == "ok" for row in rows) * 0.05
    assert 0.5 < spent < 3.0
    assert rows[-1].reason == "quick"


def test_an_unknown_name_is_refused_before_anything_is_made(cli, tmp_path):
    code, out, err = cli("membrain", "--json", "--out", "figures")
    assert code == 2
    assert json.loads(out).keys() == {"error", "reason"}
    assert "did you mean 'membrane'" in err
    assert list(tmp_path.iterdir()) == []


def test_what_was_measured_before_an_interrupt_is_kept_and_said(cli, tmp_path, bench, monkeypatch):
    def stopped():
        raise KeyboardInterrupt

    monkeypatch.setattr(bench, "lost", stopped)
    code, _, err = cli("membrane", "--out", str(tmp_path / "rows"))
    assert code == 130
    assert f"stopped after 1 row; {tmp_path / 'rows'} keeps them" in err
    assert [row.setting.variant for row in read(tmp_path / "rows" / "accuracy.jsonl")] == ["coarse"]
    assert "give --out to keep them" in cli("membrane")[2]
