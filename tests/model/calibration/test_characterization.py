"""The table of a characterisation: a written table is read again as it was, and a mistake is named with its line."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.strategies.model import PRESSES, PROVENANCES
from stretch_bt.model.calibration.characterization import (
    NAME,
    first_lines,
    parse_table,
    read_table,
    table_line,
)

TOP = first_lines({"scene": "calibration_sphere", "seed": 3})


@given(PROVENANCES, st.lists(PRESSES, max_size=8))
def test_what_is_written_is_read(provenance, rows):
    table = parse_table(first_lines(provenance) + "".join(map(table_line, rows)))
    assert table.provenance == provenance
    assert len(table) == len(rows)
    for row, read in zip(rows, table.presses(), strict=True):
        assert (read.geometry, read.trial) == (row.geometry, row.trial)
        for name in ("size", "stretch", "depth", "force", "force_sd", "contact_height", "time"):
            assert getattr(read, name) == pytest.approx(getattr(row, name), rel=1e-8, abs=1e-12)


@given(PRESSES)
def test_a_line_that_was_read_is_written_alike(press):
    once = next(parse_table(TOP + table_line(press)).presses())
    twice = next(parse_table(TOP + table_line(once)).presses())
    assert table_line(once) == table_line(twice)


@given(st.lists(PRESSES, min_size=1, max_size=4), st.data())
def test_a_table_that_was_cut_anywhere_is_refused_or_lacks_whole_rows(rows, data):
    text = TOP + "".join(map(table_line, rows))
    cut = text[: data.draw(st.integers(0, len(text) - 1))]
    try:
        table = parse_table(cut)
    except InvalidInput as error:
        assert str(error).startswith(f"{NAME}:")
    else:
        assert cut.endswith("\n")
        assert len(table) < len(rows)


@given(st.text())
def test_no_text_is_read_as_nonsense(text):
    try:
        table = parse_table(TOP + text)
    except InvalidInput as error:
        assert str(error).startswith(f"{NAME}:")
    else:
        assert all(math.isfinite(v) for v in (*table.force, *table.depth, *table.size))


def test_files_that_are_none(tmp_path):
    with pytest.raises(InvalidInput, match=r"none\.csv: the table cannot be read"):
        read_table(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(InvalidInput, match="the table is no text"):
        read_table(tmp_path / "picture.csv")
