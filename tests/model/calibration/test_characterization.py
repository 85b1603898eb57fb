"""The table of a characterisation: what is written is read again, and what is wrong is named with its line."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.characterization import (
    COLUMNS,
    NAME,
    Press,
    first_lines,
    parse_table,
    read_table,
    table_line,
)

TOP = first_lines({"scene": "calibration_sphere", "seed": 3})
ROW = "sphere,20,,10,5,1,0.4,0.004,60.1,12.5\n"

lengths = st.floats(0.0, 0.3)
sizes = st.floats(0.001, 1.5)
numbers = st.floats(-1e3, 1e3)
presses = st.builds(
    Press,
    st.sampled_from(["sphere", "cylinder", "cone"]),
    sizes,
    lengths,
    st.floats(-0.005, 0.03),
    st.integers(1, 50),
    numbers,
    st.floats(0.0, 10.0),
    lengths,
    st.floats(0.0, 1e6),
)
provenances = st.dictionaries(st.text(), st.none() | st.booleans() | st.integers() | st.text(), max_size=4)


@given(provenances, st.lists(presses, max_size=8))
def test_what_is_written_is_read(provenance, rows):
    table = parse_table(first_lines(provenance) + "".join(map(table_line, rows)))
    assert table.provenance == provenance
    assert len(table) == len(rows)
    for row, read in zip(rows, table.presses(), strict=True):
        assert (read.geometry, read.trial) == (row.geometry, row.trial)
        for name in ("size", "stretch", "depth", "force", "force_sd", "contact_height", "time"):
            assert getattr(read, name) == pytest.approx(getattr(row, name), rel=1e-8, abs=1e-12)


@given(presses)
def test_a_line_that_was_read_is_written_alike(press):
    once = next(parse_table(TOP + table_line(press)).presses())
    twice = next(parse_table(TOP + table_line(once)).presses())
    assert table_line(once) == table_line(twice)


@given(st.lists(presses, min_size=1, max_size=4), st.data())
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


def test_the_columns_are_si():
    table = parse_table(TOP + ROW + "cone,,45,0.5,0,2,0.1,0,60.1,13\n")
    assert table.geometry.tolist() == ["sphere", "cone"]
    assert table.size.tolist() == pytest.approx([0.020, math.pi / 4])
    assert table.stretch.tolist() == pytest.approx([0.010, 0.0005])
    assert table.depth.tolist() == pytest.approx([0.005, 0.0])
    assert table.trial.tolist() == [1, 2]
    assert table.force.tolist() == pytest.approx([0.4, 0.1])
    assert table.force_sd.tolist() == pytest.approx([0.004, 0.0])
    assert table.contact_height.tolist() == pytest.approx([0.0601, 0.0601])
    assert table.time.tolist() == [12.5, 13.0]


def test_line_ends_of_another_system_are_borne():
    assert len(parse_table((TOP + ROW).replace("\n", "\r\n"))) == 1


WRONG = [
    ("", r":1: a table begins with '# stretch-characterization/1 '; name the file"),
    ("a,b\n1,2\n", r":1: a table begins with"),
    ("# stretch-characterization/1 {\n", r":1: what the table comes from is no JSON"),
    ("# stretch-characterization/1 []\n", r":1: what the table comes from is a JSON object"),
    (TOP.splitlines()[0] + "\n", r":2: the header of a table is geometry,"),
    (TOP.replace("depth_mm", "depth"), r":2: the header of a table is geometry,"),
    (TOP + ROW + ROW[:-1], r":4: the last line has no line end, .*; remove the line, or run characterize"),
    (TOP + ROW + "\n" + ROW, r":4: a row has 10 columns, this one 1"),
    (TOP + ROW.replace("sphere", "cube"), r":3: geometry: there is no 'cube'; write one of sphere, cylinder, cone"),
    (TOP + ROW.replace("20,,", "20,45,"), r":3: angle_deg: '45' stands where this geometry has none"),
    (TOP + ROW.replace("sphere", "cone"), r":3: diameter_mm: '20' stands where"),
    (TOP + ROW.replace("20,,", ",,"), r":3: diameter_mm: '' is no finite number"),
    (TOP + ROW.replace("0.4", "nan"), r":3: force_N: 'nan' is no finite number"),
    (TOP + ROW.replace("0.4", "1e999"), r":3: force_N: '1e999' is no finite number"),
    (TOP + ROW.replace(",5,1,", ",5,1.5,"), r":3: trial: '1.5' is no whole number"),
    (TOP + ROW.replace(",5,1,", ",5,0,"), r":3: trial: 0 is below 1"),
    (TOP + ROW.replace("0.004", "-0.004"), r":3: force_sd_N: -0.004 is below 0"),
    (TOP + ROW.replace("20,,", "0,,"), r":3: the size of the indenter is 0"),
]


@pytest.mark.parametrize(("text", "said"), WRONG)
def test_what_is_wrong_is_named_with_file_and_line(tmp_path, text, said):
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(InvalidInput, match=r"table\.csv" + said):
        read_table(path)


def test_files_that_are_none(tmp_path):
    with pytest.raises(InvalidInput, match=r"none\.csv: the table cannot be read"):
        read_table(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(InvalidInput, match="the table is no text"):
        read_table(tmp_path / "picture.csv")


@pytest.mark.parametrize("name", ["force", "force_sd", "contact_height", "time", "size", "stretch", "depth"])
def test_no_row_is_written_without_a_number(name):
    from dataclasses import replace

    press = Press("sphere", 0.02, 0.0, 0.005, 1, 0.4, 0.004, 0.06, 1.0)
    assert table_line(press).count(",") == len(COLUMNS) - 1
    with pytest.raises(InvalidInput, match="finite"):
        table_line(replace(press, **{name: math.nan}))
