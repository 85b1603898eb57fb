"""The command `sweep`: its JSON, its exit codes, and what it says."""

import json

import pytest

TREE = """\
format: stretch-tree/1
params: {number: {default: 1}}
trees: {main: {out: {reached: int}, sequence: [{set: {reached: "2 * number"}}, {check: {that: "number < 3"}}]}}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "count.yaml").write_text(TREE)
    (tmp_path / "sweep.yaml").write_text("format: stretch-sweep/1\ntree: count.yaml\nset: {number: [1, 2, 3]}\n")
    return tmp_path


def test_json_is_one_document_and_rows_are_in_the_folder(cli, folder):
    code, out, err = cli("sweep", "sweep.yaml", "--out", "out", "--resume", "--json")
    assert "nothing to go on with" in err
    found = json.loads(out)
    assert (code, found["items"], found["statuses"]) == (0, 3, {"SUCCESS": 2, "FAILURE": 1})
    assert found["folder"] == str(folder / "out")
    assert {"rows.jsonl", "summary.json", "sweep.yaml", "reached.svg"} == {p.name for p in (folder / "out").iterdir()}
    code, out, err = cli("sweep", "sweep.yaml", "--out", "out", "--resume", "--json")
    assert "nothing to go on with" not in err
    assert (code, json.loads(out)["before"]) == (0, 3)


def test_for_a_person_it_says_what_came_of_each_group(cli, folder):
    code, out, _ = cli("sweep", "sweep.yaml")
    assert code == 0
    assert "3 of 3 items: 1 FAILURE, 2 SUCCESS" in out
    assert "count.yaml, number=2" in out
    assert "1 x main/check" in out
    assert "runs/" in out


def test_an_item_without_an_end_of_its_own_is_exit_1(cli, folder):
    (folder / "sweep.yaml").write_text("format: stretch-sweep/1\ntree: long.yaml\nlimit: 50 ms\n")
    (folder / "long.yaml").write_text("format: stretch-tree/1\ntrees: {main: {sequence: [{wait: {duration: 10 h}}]}}\n")
    code, out, _ = cli("sweep", "sweep.yaml", "--json")
    assert (code, json.loads(out)["statuses"]) == (1, {"timed_out": 1})


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("sweep.yaml", "--engine", "dusk"), "did you mean 'dask'"),
        (("sweep.yaml", "--resume"), "name it with --out"),
        (("nothing.yaml",), "no such file"),
        (("count.yaml",), "stretch-sweep/1"),
    ],
)
def test_bad_input_is_exit_2(cli, folder, arguments, said):
    code, _, err = cli("sweep", *arguments)
    assert code == 2
    assert said in err
    assert "Traceback" not in err


def test_the_schema_and_the_check_know_sweeps(cli, folder):
    code, out, _ = cli("schema", "sweep")
    assert (code, json.loads(out)["properties"]["format"]["const"]) == (0, "stretch-sweep/1")
    assert cli("check", "sweep.yaml", "--json")[:2] == (0, "[]\n")


def test_what_was_done_before_an_interrupt_is_told(cli, folder, monkeypatch):
    """It ended without a word, and the folder had to be guessed."""
    from stretch_bt.sweep import sweeping

    keep = sweeping._keep

    def kept_and_interrupted(rows, ran):
        keep(rows, ran)
        raise KeyboardInterrupt("SIGINT")

    monkeypatch.setattr(sweeping, "_keep", kept_and_interrupted)
    code, _, err = cli("sweep", "sweep.yaml", "--out", "out")
    assert code == 130
    assert err.count(f"1 of 3 items have a row; go on with --resume --out {folder / 'out'}") == 1
    monkeypatch.setattr(sweeping, "_keep", keep)
    code, out, _ = cli("sweep", "sweep.yaml", "--resume", "--out", "out", "--json")
    assert (code, json.loads(out)["before"]) == (0, 1)
