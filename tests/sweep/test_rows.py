"""The file of rows: whole lines on the disk, the last row of a key counts, and a torn one is dropped."""

import json
import resource

import pytest

from stretch_bt.errors import InvalidInput, RecordError
from stretch_bt.sweep.rows import ROWS, RowFile


def row(key, status="SUCCESS", **more):
    return {"key": key, "status": status, **more}


def lines(folder):
    return (folder / ROWS).read_bytes().splitlines(keepends=True)


@pytest.fixture
def rows(tmp_path):
    opened = []

    def make():
        opened.append(RowFile(tmp_path / ROWS))
        return opened[-1]

    yield make
    for file in opened:
        file.close()


def test_each_row_is_on_the_disk_when_it_is_written(rows, tmp_path):
    file = rows()
    for k in range(3):
        file.write(row(f"k{k}", text="é"))
        assert [json.loads(line)["key"] for line in lines(tmp_path)] == [f"k{n}" for n in range(k + 1)]


def test_the_last_row_of_a_key_counts(rows):
    file = rows()
    for status in ("killed", "SUCCESS"):
        file.write(row("a", status, number=status))
        file.write(row("b", number=1))
    assert [found["number"] for found in file.rows(iter(["b", "a", "c"]))] == [1, "SUCCESS"]
    assert file.statuses == {"a": "SUCCESS", "b": "SUCCESS"}


@pytest.mark.parametrize("left", [1, 10, 30])
def test_a_torn_last_line_is_dropped_and_the_next_row_begins_there(rows, tmp_path, left):
    file = rows()
    for key in ("a", "b"):
        file.write(row(key, text="x" * 20_000))
    file.close()
    whole = lines(tmp_path)
    (tmp_path / ROWS).write_bytes(whole[0] + whole[1][:left])
    again = rows()
    assert again.statuses == {"a": "SUCCESS"}
    again.write(row("c"))
    assert [json.loads(line)["key"] for line in lines(tmp_path)] == ["a", "c"]
    assert [len(found.get("text", "")) for found in again.rows(iter(["a", "c"]))] == [20_000, 0]


@pytest.mark.parametrize(
    "line",
    [
        b"{\n",
        b"[]\n",
        b"{}\n",
        b'{"key": 1, "status": "SUCCESS"}\n',
        b'{"key": "a", "status": "SUCCESS", "x": NaN}\n',
        b'{"key": "a", "status": "SUCCESS", "x": 1e999}\n',
        b"\xff\n",
    ],
)
def test_a_line_that_is_no_row_is_told_at_its_place(rows, tmp_path, line):
    file = rows()
    file.write(row("a"))
    file.close()
    (tmp_path / ROWS).write_bytes(lines(tmp_path)[0] + line + lines(tmp_path)[0])
    with pytest.raises(RecordError, match=r"rows\.jsonl:2:1 error\[rows-damaged\]"):
        rows()


def test_one_sweep_at_a_time_writes_to_a_file(rows):
    first = rows()
    with pytest.raises(InvalidInput, match="another sweep writes to this file"):
        rows()
    first.close()
    rows()


def test_a_full_disk_is_told_and_what_it_took_of_the_row_is_dropped(rows, tmp_path):
    file = rows()
    file.write(row("a"))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60, before[1]))
    try:
        with pytest.raises(InvalidInput, match="File too large; make room and go on with --resume"):
            file.write(row("b", text="x" * 100))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert len((tmp_path / ROWS).read_bytes()) == 60
    file.close()
    assert rows().statuses == {"a": "SUCCESS"}
