"""The command accuracy, on a domain that is quick to measure."""

import json
import sys
from types import SimpleNamespace

import pytest

from stretch_bt.accuracy import Kind, Point, registry
from stretch_bt.cli.app import main

FIELDS = ["domain", "case", "setting", "seed", "error", "error_kind", "cpu_seconds", "status", "versions", "cpu"]


def points(quick):
    print("what another program prints")  # noqa: T201
    yield Point("a press", "solver: coarse", "force", 0.02, 0.001)
    if not quick:
        yield Point("a press", "solver: fine", "force", 0.001, 0.1, seed=3)


@pytest.fixture
def cli(tmp_path, monkeypatch, capfd):
    """Run the command in an empty folder: (exit code, standard output, standard error)."""
    monkeypatch.chdir(tmp_path)
    domain = SimpleNamespace(ABOUT="against nothing", KINDS={"force": Kind("%", 100.0)}, points=points)
    monkeypatch.setattr(registry, "import_module", lambda name: domain)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["stretch-bt", "accuracy", *arguments])
        with pytest.raises(SystemExit) as exited:
            main()
        return exited.value.code or 0, *capfd.readouterr()

    return call


def test_rows_are_the_contract(cli):
    code, out, _ = cli("membrane", "--json")
    rows = json.loads(out)
    assert code == 0
    assert [list(row) for row in rows] == [FIELDS, FIELDS]
    assert [row["seed"] for row in rows] == [None, 3]
    for row in rows:
        assert row["domain"] == "membrane"
        assert row["versions"].keys() == {"stretch-bt", "numpy", "scipy", "numba", "python"}
        assert row["cpu"]


def test_quick_is_less_and_no_name_is_all(cli):
    domains = len(registry.domains())
    assert len(json.loads(cli("membrane", "--quick", "--json")[1])) == 1
    assert len(json.loads(cli("--quick", "--json")[1])) == domains


def test_the_table_is_for_people(cli):
    code, out, _ = cli("membrane")
    assert code == 0
    assert "against nothing" in out
    assert "what another program prints" not in out
    assert "solver: fine" in out


def test_out_holds_the_rows_and_must_be_empty(cli, tmp_path):
    code, out, _ = cli("membrane", "--json", "--out", "figures")
    assert code == 0
    assert json.loads((tmp_path / "figures" / "accuracy.json").read_text()) == json.loads(out)
    before = (tmp_path / "figures" / "accuracy.json").stat().st_mtime_ns
    code, _, err = cli("membrane", "--out", "figures")
    assert code == 2
    assert "record-not-empty" in err
    assert (tmp_path / "figures" / "accuracy.json").stat().st_mtime_ns == before


def test_an_unknown_name_is_refused_before_anything_is_made(cli, tmp_path):
    code, out, err = cli("membrain", "--json", "--out", "figures")
    assert code == 2
    assert json.loads(out).keys() == {"error", "reason"}
    assert "did you mean 'membrane'" in err
    assert list(tmp_path.iterdir()) == []
