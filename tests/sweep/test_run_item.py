"""One item: whatever it comes to is a row, and it changes nothing of the process and sees nothing of another item."""

import platform
import signal
import sys
import threading
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from stretch_bt.errors import InvalidInput, MissingExtra
from stretch_bt.sweep import run_item, wall_limit
from stretch_bt.sweep.laid_out import laid_out

FIELDS = {
    "key", "tree", "scene", "seed", "set", "status", "reason", "outputs", "truth", "ticks",
    "task_seconds", "wall_seconds", "cpu_seconds", "worker",
}  # fmt: skip


@pytest.fixture
def own(lab, own_nodes, request):
    """A sweep of one node whose body is given, in a module of the test's own."""

    def make(body, more=""):
        module = f"sweep_{abs(hash(request.node.name))}"
        lines = "".join(f"        {line}\n" for line in body.splitlines())
        lab.write(
            f"{module}.py",
            "import os, signal, sys, time\nfrom pathlib import Path\n"
            "from stretch_bt import Behavior, Out, Status, node\n\n\n@node\nclass Own(Behavior):\n"
            f'    """Do as the test says."""\n\n    found: Out[int]\n\n    def update(self) -> Status:\n{lines}',
        )
        lab.write(
            "own.yaml",
            f"format: stretch-tree/1\nimports: {{own: {module}}}\n"
            "trees: {main: {out: {found: int}, sequence: [{own: {found: $found}}], finally: [{wait: {duration: 0.1 s}}]}}\n",
        )
        lab.sweep(f"tree: own.yaml\n{more}")
        return lab.specs()

    return make


def test_a_row_has_what_the_contract_says(lab):
    rows = [run_item(spec).row for spec in lab.specs()]
    assert all(row.keys() == FIELDS for row in rows)
    assert [row["status"] for row in rows] == ["SUCCESS"] * 3 + ["FAILURE"]
    first, last = rows[0], rows[-1]
    assert first["outputs"] == {"reached": {"value": 2, "unit": "", "sd": None}}
    assert (first["tree"], first["scene"], first["seed"], first["set"]) == ("count.yaml", None, 0, {"number": "1"})
    assert (last["reason"], last["outputs"]) == ("main/check: 4 is too much", {})


def test_a_run_that_does_not_begin_is_a_row_without_a_path(lab, tmp_path):
    lab.sweep("tree: palpate_stiffness\nset: {model: nothing.json}")
    (spec,) = lab.specs()
    row = run_item(spec).row
    assert row["status"] == "ERROR"
    assert "nothing.json" in row["reason"]
    assert str(tmp_path) not in row["reason"]
    assert "stretch-" not in row["reason"]


def test_the_tolerance_is_that_of_the_run(lab):
    lab.sweep("tree: count.yaml\ntolerance: {stiffness: 2 %}")
    row = run_item(lab.specs()[0]).row
    assert row["status"] == "ERROR"  # nothing is simulated here that it could bound
    assert "leave out tolerance" in row["reason"]  # as it is written in a sweep file


def test_a_defect_of_ours_is_a_row_too(lab, monkeypatch):
    module = sys.modules["stretch_bt.sweep.run_item"]
    monkeypatch.setattr(module, "run", lambda *_, **__: 1 / 0)
    assert run_item(lab.specs()[0]).row["reason"] == "ZeroDivisionError: division by zero"


def test_a_package_that_a_worker_lacks_is_no_row_of_an_item(lab, monkeypatch):
    """Each item was an ERROR, which --resume does not run again."""

    def lacks(*_, **__):
        raise MissingExtra("mesh files need trimesh: pip install 'stretch-bt[mesh]'")

    monkeypatch.setattr(sys.modules["stretch_bt.sweep.run_item"], "run", lacks)
    with pytest.raises(MissingExtra, match=rf"{platform.node()}:\d+ lacks .* trimesh: pip install .* with --resume"):
        run_item(lab.specs()[0])


def test_what_a_node_writes_beside_is_gone_when_the_next_begins(own, lab, tmp_path):
    before = Path.cwd()
    body = "Path('left').write_text('1')\nself.found = len(list(Path().iterdir()))\nreturn Status.SUCCESS"
    lab.write("table.csv", "1,2\n")
    specs = own(body, "seeds: 2")
    assert [run_item(spec).row["outputs"]["found"]["value"] for spec in specs] == [
        len(spec.files) + 1 for spec in specs
    ]
    assert Path.cwd() == before
    assert not (lab.folder / "left").exists()


def test_what_nodes_print_is_not_on_standard_output(own, capfd):
    (spec,) = own("print('loud')\nself.found = 1\nreturn Status.SUCCESS")
    assert run_item(spec).row["status"] == "SUCCESS"
    out, err = capfd.readouterr()
    assert (out, "loud" in err) == ("", True)


@pytest.mark.parametrize("threaded", [False, True])
def test_past_its_limit_a_run_is_stopped_safely_at_its_next_tick(own, threaded):
    """In a thread it is run by Dask."""
    (spec,) = own("time.sleep(0.02)\nreturn Status.RUNNING", "limit: 100 ms")
    found = []
    thread = threading.Thread(target=lambda: found.append(run_item(spec)))
    thread.start() if threaded else found.append(run_item(spec))
    if threaded:
        thread.join()
    (ran,) = found
    assert (ran.row["status"], ran.row["reason"], ran.stopped) == (
        "timed_out",
        "no end within 0.1 s of wall time",
        False,
    )
    assert ran.row["ticks"] >= 3  # its `finally` waits two ticks


def test_a_module_that_a_node_imported_as_it_ticked_is_refused_once_it_is_changed(lab, own_nodes):
    node = (
        "from stretch_bt import Behavior, Status, node\n\n\n@node\nclass Lazy(Behavior):\n"
        '    """Import as it ticks."""\n\n    def update(self) -> Status:\n'
        "        from . import later\n\n        return Status.SUCCESS\n"
    )
    lab.write("sweep_lazy/__init__.py", node)
    later = lab.write("sweep_lazy/later.py", "NUMBER = 1\n")
    lab.write(
        "own.yaml", "format: stretch-tree/1\nimports: {own: sweep_lazy}\ntrees: {main: {sequence: [{lazy: {}}]}}\n"
    )
    lab.sweep("tree: own.yaml")
    (spec,) = lab.specs()
    assert run_item(spec).row["status"] == "SUCCESS"
    later.write_text("NUMBER = 2\n")
    (changed,) = lab.specs()
    assert changed.key != spec.key
    with pytest.raises(InvalidInput, match="imported another 'sweep_lazy', of an earlier sweep"):
        run_item(changed)


LATE = "sys.modules['stretch_bt.sweep.wall_limit'].time.now += 1e9\n"  # the limit of an item is over
KILL = "os.kill(os.getpid(), signal.SIGTERM)\n"
RUNNING, DONE = "return Status.RUNNING", "self.found = 1\nreturn Status.SUCCESS"


@pytest.mark.parametrize(
    ("body", "status", "stopped"),
    [
        (f"{LATE}{DONE}", "SUCCESS", False),  # its `finally` is not cut short
        (f"{KILL}{LATE}{RUNNING}", "INTERRUPTED", True),
        (f"{LATE}{KILL}{RUNNING}", "INTERRUPTED", True),
        (f"if hasattr(self, 'late'):\n    {KILL}else:\n    {LATE}self.late = 1\n{RUNNING}", "timed_out", True),
        (f"{LATE}{RUNNING}", "timed_out", False),
    ],
)
def test_the_limit_takes_neither_a_task_that_is_done_nor_a_signal(own, monkeypatch, body, status, stopped):
    clock = SimpleNamespace(now=0.0, perf_counter=lambda: clock.now)
    monkeypatch.setattr(wall_limit, "time", clock)
    (spec,) = own(body, "limit: 1 min")
    ran = run_item(spec)
    assert (ran.row["status"], ran.stopped) == (status, stopped)


@pytest.mark.parametrize("body", ["os.kill(os.getpid(), signal.SIGTERM)", "raise KeyboardInterrupt"])
def test_a_signal_ends_the_item_without_a_row_but_own_code_that_raises_alike_has_one(own, body):
    (spec,) = own(f"{body}\nreturn Status.RUNNING")
    before = signal.getsignal(signal.SIGTERM)
    ran = run_item(spec)
    assert (ran.row["status"], ran.stopped) == ("INTERRUPTED", "kill" in body)
    assert signal.getsignal(signal.SIGTERM) == before


def test_a_worker_with_another_package_refuses(lab):
    with pytest.raises(InvalidInput, match="install the same version"):
        run_item(replace(lab.specs()[0], source="another"))


def test_files_of_the_record_come_back_where_they_are_asked_for(lab):
    lab.sweep("tree: count.yaml\nrecord: events")
    assert run_item(lab.specs()[0]).record.keys() == {"run.json", "events.jsonl", "result.json"}
    lab.sweep("tree: count.yaml")
    assert run_item(lab.specs()[0]).record is None


def test_a_worker_elsewhere_lays_out_the_files(lab, tmp_path):
    """What a process has not at their places it writes, once."""
    lab.write("rest.yaml", "format: stretch-tree/1\ntrees: {rest: {sequence: [{wait: {duration: 0.1 s}}]}}\n")
    lab.write("own.yaml", "format: stretch-tree/1\nimports: {lib: rest.yaml}\ntrees: {main: {sequence: [lib.rest]}}\n")
    lab.sweep("tree: own.yaml")
    (spec,) = lab.specs()
    there = replace(spec, files={f"deep/{name}": content for name, content in spec.files.items()}, home="deep")
    assert run_item(there).row["status"] == "SUCCESS"
    folder = laid_out(there.files)
    assert folder == laid_out(there.files)
    assert not folder.is_relative_to(tmp_path)


def test_a_file_that_is_changed_while_the_sweep_runs_counts_as_it_was(lab):
    """Where a node changes the copy of a worker too, of which an item after it would see."""
    spec = lab.specs()[0]
    (lab.folder / "count.yaml").write_text("format: stretch-tree/1\n")
    assert run_item(spec).row["status"] == "SUCCESS"
    copy = laid_out(spec.files) / "count.yaml"
    copy.write_text("format: stretch-tree/1\n")
    assert run_item(spec).row["status"] == "SUCCESS"
    copy.unlink()
    assert run_item(spec).row["status"] == "SUCCESS"


def test_another_module_of_the_same_name_is_refused(own, lab):
    (spec,) = own("self.found = 1\nreturn Status.SUCCESS")
    assert run_item(spec).row["status"] == "SUCCESS"
    changed = {name: content.replace(b"= 1", b"= 2") for name, content in spec.files.items()}
    with pytest.raises(InvalidInput, match="restart the workers"):
        run_item(replace(spec, files=changed))


@pytest.mark.parametrize("inner", ["__init__", "nodes"])
def test_a_package_of_an_earlier_sweep_is_refused_where_its_text_is_another(lab, own_nodes, inner):
    """Each item was an ERROR of its own, which --resume does not run again; and one was refused whose tree alone had changed."""
    package = f"sweep_package_{inner.strip('_')}"  # without an __init__.py it has no file of its own
    lab.write(f"{package}/{inner}.py", "NUMBER = 1\n")
    name = package if inner == "__init__" else f"{package}.{inner}"
    tree = f"format: stretch-tree/1\nimports: {{own: {name}}}\ntrees: {{main: {{sequence: [{{wait: {{duration: 1 s}}}}]}}}}\n"
    lab.write("own.yaml", tree)
    lab.sweep("tree: own.yaml")
    (spec,) = lab.specs()
    assert run_item(spec).row["status"] == "SUCCESS"
    again = replace(spec, files=spec.files | {"own.yaml": f"{tree}# changed\n".encode()})
    assert run_item(again).row["status"] == "SUCCESS"
    with pytest.raises(InvalidInput, match=f"another '{package}', of an earlier sweep; restart the workers"):
        run_item(replace(spec, files=spec.files | {f"{package}/{inner}.py": b"NUMBER = 2\n"}))
