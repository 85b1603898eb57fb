"""The command hardcases, on a domain that is quick."""

import json

import pytest
from typer.testing import CliRunner

from stretch_bt.cli.app import app
from stretch_bt.hardcases import Hard, Value, registry

KEYS = ["domain", "name", "expected", "outcome", "ok", "iterations", "residual", "seconds"]


@pytest.fixture
def only(monkeypatch):
    """Put some cases in the place of a domain's cases."""

    def put(*cases):
        monkeypatch.setattr(registry, "cases", lambda domain: {case.name: case for case in cases})
        monkeypatch.setattr("stretch_bt.hardcases.cases", registry.cases)

    return put


def asked(*arguments):
    return CliRunner().invoke(app, ["hardcases", *arguments])


def test_rows_are_one_json_document(only):
    some = registry.load("fits")[::100]
    only(*some)
    done = asked("--domain", "fits", "--json")
    assert done.exit_code == 0
    rows = json.loads(done.stdout)
    assert [list(row) for row in rows] == [KEYS] * len(some)
    assert [row["name"] for row in rows] == [hard.name for hard in some]
    assert {(row["domain"], row["ok"], row["iterations"], row["residual"]) for row in rows} == {
        ("fits", True, None, None)
    }
    assert all(row["seconds"] >= 0 and row["expected"] and row["outcome"] for row in rows)


@pytest.mark.parametrize("json_", [True, False])
def test_a_case_that_does_not_end_as_it_must_is_a_failure(only, json_):
    only(Hard("right", "it is right", lambda: 1, Value(1)), Hard("wrong", "it is wrong", lambda: 2, Value(1)))
    done = asked("--domain", "fits", *["--json"] * json_)
    assert done.exit_code == 1
    if json_:
        assert [row["ok"] for row in json.loads(done.stdout)] == [True, False]
    else:
        assert "ok  fits: right: 1\nno  fits: wrong: 1\n    2\n2 cases, 1 do not end as they must" in done.stdout


def test_an_unknown_domain_is_bad_input():
    done = asked("--domain", "percepton")
    assert "did you mean 'perception'?" in str(done.exception)
