"""A sweep from its file to rows, summary and pictures; items that run again, and refusals."""

import errno
import json
import math
import re
import resource
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from stretch_bt.errors import InvalidInput, RecordError, StretchError, SweepError
from stretch_bt.sweep import Ran, sweep
from stretch_bt.sweep.rows import ROWS, RowFile
from stretch_bt.sweep.summary import Summary


def noted(statuses, taken):
    """Return an engine that runs nothing: it notes its items, and reports SUCCESS or the given status."""

    def engine(specs):
        for spec in specs:
            taken.append((spec.params["number"], spec.seed))
            status = statuses.get(taken[-1], "SUCCESS")
            yield Ran(spec.row(status, ""), stopped=status == "stopped")

    return engine


def test_each_item_has_a_row_and_rows_are_summed_up(lab, tmp_path, rows):
    told = []
    found = sweep(lab.file, out=tmp_path / "out", progress=lambda row, done, of: told.append((row["status"], done, of)))
    assert found.whole
    assert (found.before, found.stopped, found.summary.statuses) == (0, 0, {"SUCCESS": 3, "FAILURE": 1})
    assert [(done, of) for _, done, of in told] == [(k, 4) for k in range(1, 5)]
    assert len(rows(found.folder)) == 4
    assert (found.folder / "sweep.yaml").read_text() == lab.file.read_text()
    summary = json.loads((found.folder / "summary.json").read_text())
    assert [group["items"] for group in summary["groups"]] == [1] * 4
    assert summary["groups"][1]["outputs"]["reached"]["mean"] == 4.0
    assert summary["groups"][3]["reasons"] == {"main/check: 4 is too much": 1}
    assert summary.items() <= found.to_json().items()
    assert found.pictures == ["reached.svg"]
    picture = ElementTree.parse(found.folder / "reached.svg").getroot()
    assert len(picture.findall(".//{*}circle")) == 3


@pytest.fixture
def eight(lab):
    """The sweep with two seeds."""
    lab.file.write_text(f"{lab.file.read_text()}seeds: 2\n")
    return lab


def test_only_what_has_no_row_was_killed_or_timed_out_is_run_again(eight, tmp_path):
    ends = {("1", 0): "killed", ("2", 1): "timed_out", ("3", 0): "stopped", ("4", 1): "ERROR"}
    taken = []
    first = sweep(eight.file, noted(ends, taken), out=tmp_path / "out")
    assert (len(taken), first.stopped, first.whole) == (8, 1, False)
    taken.clear()
    again = sweep(eight.file, noted({}, taken), out=tmp_path / "out", resume=True)
    assert taken == [("1", 0), ("2", 1), ("3", 0)]
    assert (again.before, again.whole, again.summary.statuses) == (5, True, {"SUCCESS": 7, "ERROR": 1})


def test_a_sweep_that_was_killed_within_a_row_goes_on(lab, tmp_path, rows):
    whole = sweep(lab.file, out=tmp_path / "whole")
    torn = sweep(lab.file, out=tmp_path / "torn")
    path = torn.folder / "rows.jsonl"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    again = sweep(lab.file, out=torn.folder, resume=True)
    assert 1 <= again.before <= 2
    assert rows(again.folder) == rows(whole.folder)


def test_rows_of_another_tree_do_not_count(eight, tmp_path):
    taken = []
    sweep(eight.file, noted({}, taken), out=tmp_path / "out")
    (eight.folder / "count.yaml").write_text((eight.folder / "count.yaml").read_text() + "# changed\n")
    again = sweep(eight.file, noted({}, taken), out=tmp_path / "out", resume=True)
    assert (len(taken), again.before, again.summary.items) == (16, 0, 8)


def test_after_an_interrupt_the_items_that_have_a_row_are_counted(eight, tmp_path):
    """Rows of another tree were counted with them: 9 of 8."""
    sweep(eight.file, noted({}, []), out=tmp_path / "out")
    eight.write("count.yaml", (eight.folder / "count.yaml").read_text() + "# changed\n")

    def interrupted(specs):
        yield next(noted({}, [])(specs))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        sweep(eight.file, interrupted, out=tmp_path / "out", resume=True)
    assert stopped.value.__notes__ == [f"1 of 8 items have a row; go on with --resume --out {tmp_path / 'out'}"]


def test_more_items_are_gone_on_with(eight, tmp_path):
    taken = []
    sweep(eight.file, noted({}, taken), out=tmp_path / "out")
    eight.file.write_text(eight.file.read_text().replace("seeds: 2", "seeds: 3"))
    again = sweep(eight.file, noted({}, taken), out=tmp_path / "out", resume=True)
    assert (again.before, {seed for _, seed in taken[8:]}) == (8, {2})


def test_a_row_is_never_without_its_record(lab, tmp_path):
    lab.file.write_text("format: stretch-sweep/1\ntree: count.yaml\nrecord: events\n")
    found = sweep(lab.file, out=tmp_path / "out")
    folders = {path.name for path in (found.folder / "records").iterdir()}
    assert folders == {json.loads(line)["key"] for line in (found.folder / "rows.jsonl").read_text().splitlines()}
    result = json.loads((found.folder / "records" / folders.pop() / "result.json").read_text())
    assert result["status"] in ("SUCCESS", "FAILURE")


def test_folders_that_cannot_be_used_are_refused_before_anything_runs(lab, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    with pytest.raises(InvalidInput, match=f"^{tmp_path}/full: the folder is not empty; name a new folder"):
        sweep(lab.file, out=tmp_path / "full")
    with pytest.raises(InvalidInput, match=f"^{tmp_path}/full/file: this is a file; the output of a sweep is a folder"):
        sweep(lab.file, out=tmp_path / "full" / "file")
    with pytest.raises(InvalidInput, match=r"it holds no rows\.jsonl of a sweep"):
        sweep(lab.file, out=tmp_path / "full", resume=True)
    with pytest.raises(InvalidInput, match="name it with --out"):
        sweep(lab.file, resume=True)
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["file"]


def test_the_folder_of_a_sweep_is_gone_on_in(lab, tmp_path):
    """It was said to be not empty, and that it should be emptied, which takes its rows."""
    sweep(lab.file, out=tmp_path / "out")
    with pytest.raises(InvalidInput, match="go on with --resume"):
        sweep(lab.file, out=tmp_path / "out")


@pytest.mark.parametrize("kind", [InvalidInput, StretchError, MemoryError])
@pytest.mark.parametrize("there", [False, True])
def test_an_engine_that_does_not_begin_leaves_no_folder_that_is_in_use(lab, tmp_path, there, kind):
    def refuses(specs):
        raise kind("there is no scheduler")
        yield

    out = tmp_path / "out"
    if there:
        out.mkdir()
    with pytest.raises(kind, match="no scheduler"):
        sweep(lab.file, refuses, out=out)
    assert not out.exists()
    assert sweep(lab.file, out=out).whole is True


def test_a_full_disk_is_told_with_the_file_that_was_written_and_the_next_step(lab, tmp_path, monkeypatch):
    """The sweep file itself was named, or nothing; and what had begun was in the way of the next try."""
    full = {"sweep.yaml"}
    write = Path.write_bytes

    def written(path, content):
        if path.name in full:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    def recorded(specs):
        for spec in specs:
            yield Ran(spec.row("SUCCESS", ""), {"run.json": b"{}"})

    monkeypatch.setattr(Path, "write_bytes", written)
    out = tmp_path / "out"
    with pytest.raises(InvalidInput, match=f"^{out}/sweep.yaml: cannot write .*: No space left on device; make room"):
        sweep(lab.file, recorded, out=out)
    assert not out.exists()
    full.clear()
    full.add("run.json")
    with pytest.raises(InvalidInput, match=f"^{out}/records/.*: cannot write the record .* go on with --resume"):
        sweep(lab.file, recorded, out=out)
    assert list((out / "records").iterdir()) == []
    full.clear()
    assert sweep(lab.file, recorded, out=out, resume=True).whole


def test_a_worker_that_reads_the_script_of_a_sweep_does_not_sweep(lab, tmp_path, monkeypatch):
    process = SimpleNamespace(_inheriting=True, name="Dask Worker process (from Nanny)")
    monkeypatch.setattr("multiprocessing.current_process", lambda: process)
    with pytest.raises(SystemExit):
        sweep(lab.file, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


#: a field of a row, and what may stand in its place instead of nothing
DAMAGED = {
    "tree": 1,
    "scene": [],
    "set": {"number": 1},
    "status": None,
    "reason": {},
    "outputs": {"reached": {"value": 1, "unit": None, "sd": None}},
    "truth": {"reached": 1},
    "cpu_seconds": "1",
    "wall_seconds": None,
    "task_seconds": True,
}


@pytest.mark.parametrize("field", DAMAGED)
def test_a_row_that_cannot_be_summed_up_is_told_at_its_line_before_anything_runs(lab, tmp_path, field):
    """It ended in a traceback, after all items had run."""
    taken = []
    sweep(lab.file, noted({}, []), out=tmp_path / "out")
    path = tmp_path / "out" / ROWS
    lines = path.read_text().splitlines(keepends=True)
    row = json.loads(lines[1])
    without = {name: value for name, value in row.items() if name != field}
    for damaged in (without, {**row, field: DAMAGED[field]}):
        path.write_text("".join([lines[0], json.dumps(damaged) + "\n", *lines[2:3]]))
        with pytest.raises(RecordError, match=r"rows\.jsonl:2:1 error\[rows-damaged\]"):
            sweep(lab.file, noted({}, taken), out=tmp_path / "out", resume=True)
    assert taken == []


@pytest.fixture
def full_disk():
    """Let no file grow past some bytes, when called; without a number there is room again."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda most=before[0]: resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("record", [None, {"run.json": b"{}"}])
def test_a_sweep_whose_first_row_finds_the_disk_full_goes_on_once_there_is_room(lab, tmp_path, full_disk, record):
    """Its files were removed as those of one that did not begin, and the next step that it named was refused."""

    def engine(specs):
        for spec in specs:
            full_disk(60)
            yield Ran(spec.row("SUCCESS", ""), record)

    with pytest.raises(InvalidInput, match="make room and go on with --resume"):
        sweep(lab.file, engine, out=tmp_path / "out")
    full_disk()
    assert (tmp_path / "out" / ROWS).is_file()
    assert sweep(lab.file, noted({}, []), out=tmp_path / "out", resume=True).whole


def test_an_item_whose_record_was_not_written_whole_runs_again(lab, tmp_path, full_disk):
    """It had a row, of when none was kept, and part of a record: that was taken for a whole one."""
    keys = [spec.key for spec in lab.specs()]
    sweep(lab.file, noted({}, []), out=tmp_path / "out")
    lab.file.write_text(f"{lab.file.read_text()}record: full\n")

    def recorded(most, taken):
        def engine(specs):
            for spec in specs:
                taken.append(spec.key)
                full_disk(*most)
                yield Ran(spec.row("SUCCESS", ""), {"record.mcap": b"1", "more/run.json": b"2" * 100})

        return engine

    with pytest.raises(InvalidInput, match="cannot write the record of an item: File too large"):
        sweep(lab.file, recorded([60], []), out=tmp_path / "out", resume=True)
    full_disk()
    for again in (keys, []):
        taken = []
        assert sweep(lab.file, recorded([], taken), out=tmp_path / "out", resume=True).whole
        assert taken == again
    assert {path.name for path in (tmp_path / "out/records").iterdir()} == set(keys)


def test_a_sweep_that_has_no_row_yet_keeps_its_file_where_another_is_refused(lab, tmp_path):
    """The other took the empty file of the first away, and with it all rows that it was to write."""
    (tmp_path / "out").mkdir()
    first = RowFile(tmp_path / "out" / ROWS)
    with pytest.raises(InvalidInput, match="another sweep writes to this file"):
        sweep(lab.file, out=tmp_path / "out", resume=True)
    assert first.path.is_file()
    first.close()


def test_a_wrong_file_is_refused_before_a_folder_is_made(lab, tmp_path):
    lab.sweep("tree: count.yaml\nset: {nothing: 1}")
    with pytest.raises(SweepError, match="param-unknown"):
        sweep(lab.file, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_summary_is_that_of_the_numbers():
    summary = Summary(3)
    for value, sd, truth in ((1.1, 0.1, 1.0), (0.7, 0.2, 1.0), (1.0, None, None)):
        summary.take(
            {
                "tree": "t",
                "scene": None,
                "set": {},
                "status": "SUCCESS",
                "reason": "",
                "outputs": {
                    "x": {"value": value, "unit": "N", "sd": sd},
                    "word": {"value": "a", "unit": "", "sd": None},
                },
                "truth": {} if truth is None else {"x": {"value": truth}},
                **dict.fromkeys(("cpu_seconds", "wall_seconds", "task_seconds"), 2.0),
            }
        )
    (group,) = summary.to_json()["groups"]
    assert group["outputs"].keys() == {"x"}
    assert group["outputs"]["x"] == pytest.approx(
        {
            "unit": "N",
            "count": 3,
            "mean": 2.8 / 3,
            "spread": math.sqrt(((1.1 - 2.8 / 3) ** 2 + (0.7 - 2.8 / 3) ** 2 + (1 - 2.8 / 3) ** 2) / 2),
            "stated_sd": math.sqrt((0.1**2 + 0.2**2) / 2),
            "truth": 1.0,
            "bias": -0.1,
            "rms_error": math.sqrt((0.1**2 + 0.3**2) / 2),
            "error_over_sd": math.sqrt((1.0**2 + 1.5**2) / 2),
        }
    )
    assert summary.to_json()["cpu_seconds"] == {"sum": 6.0, "median": 2.0, "p95": 2.0, "largest": 2.0}


def test_what_ran_without_a_record_runs_again_where_one_is_asked_for(lab, tmp_path):
    taken = []
    sweep(lab.file, out=tmp_path / "out")
    lab.file.write_text(f"{lab.file.read_text()}record: events\n")
    assert sweep(lab.file, out=tmp_path / "out", resume=True).before == 0
    assert len(list((tmp_path / "out/records").iterdir())) == 4
    assert sweep(lab.file, noted({}, taken), out=tmp_path / "out", resume=True).before == 4
    assert taken == []
    lab.file.write_text(lab.file.read_text().replace("events", "full"))
    assert sweep(lab.file, out=tmp_path / "out", resume=True).before == 0
    assert len(list((tmp_path / "out/records").glob("*/record.mcap"))) == 4
    for less in ("full", "events", "none"):
        lab.file.write_text(re.sub("record: .*", f"record: {less}", lab.file.read_text()))
        assert sweep(lab.file, noted({}, taken), out=tmp_path / "out", resume=True).before == 4
    assert taken == []


def test_a_sweep_goes_on_from_the_copy_of_its_file(lab, tmp_path):
    """A file was to be copied to itself."""
    taken, copy = [], tmp_path / "out" / "sweep.yaml"
    sweep(lab.file, noted({}, taken), out=copy.parent)
    lab.write(copy.parent / "count.yaml", (lab.folder / "count.yaml").read_text())
    text = copy.read_text()
    assert sweep(copy, noted({}, taken), out=copy.parent, resume=True).before == 4
    (copy.parent / ROWS).write_text("")

    def refuses(specs):
        raise InvalidInput("there is no scheduler")
        yield

    with pytest.raises(InvalidInput, match="no scheduler"):
        sweep(copy, refuses, out=copy.parent, resume=True)
    assert copy.read_text() == text
