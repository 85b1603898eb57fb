"""The table of a sensitivity map: a written table is read again as it was, and a wrong line is named."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.strategies.model import SENSED
from stretch_bt.model.calibration.sensitivity import (
    COLUMNS,
    METHODS,
    Found,
    Sensed,
    first_lines,
    parse_sensitivity,
    read_sensitivity,
    sensed_lines,
)


def text_of(*presses):
    return first_lines({"seed": 3}) + "".join(map(sensed_lines, presses))


@given(st.lists(SENSED, max_size=4))
def test_what_is_written_is_what_is_read(presses):
    table = parse_sensitivity(text_of(*presses))
    assert table.provenance == {"seed": 3}
    assert len(table.rows) == len(presses)
    for read, press in zip(table.rows, presses, strict=True):
        for name in ("size", "stretch", "depth", "time"):
            assert getattr(read, name) == pytest.approx(getattr(press, name), rel=1e-8, abs=1e-15)
        assert read.trial == press.trial
        for a, b in zip(read.found, press.found, strict=True):
            assert (a.method, a.shape, a.refused) == (b.method, b.shape, b.refused)
            assert (a.i, a.i_sd, a.j, a.j_sd) == pytest.approx((b.i, b.i_sd, b.j, b.j_sd), rel=1e-8)


def press(i=0.021, j=0.018, refused=""):
    first = Found("fit", refused=refused) if refused else Found("fit", i, 1e-4, j, 2e-4, "ellipse")
    return Sensed(
        "cylinder", 0.02, 0.01, 0.005, 1, (first, *(Found(m, 0.03, 0.0, 0.05, 0.0) for m in METHODS[1:])), 7.0
    )


def test_the_columns_are_those_of_a_tidy_table():
    first, second, _ = sensed_lines(press()).splitlines()
    row = dict(zip(COLUMNS, first.split(","), strict=True))
    assert (row["diameter_mm"], row["stretch_mm"], row["depth_mm"], row["method"]) == ("20", "10", "5", "fit")
    assert [float(row[f"error_{axis}_mm"]) for axis in "ij"] == pytest.approx([1.0, -2.0])
    assert float(row["absolute_error_mm"]) == pytest.approx(1.5)
    assert second.split(",")[4] == "paper_fit"
    refused = dict(zip(COLUMNS, sensed_lines(press(refused="nothing")).splitlines()[0].split(","), strict=True))
    assert refused["refused"] == "nothing"
    assert {
        value for name, value in refused.items() if name.startswith(("diameter_i", "diameter_j", "error", "abs"))
    } == {""}


def test_a_file_that_is_missing_or_no_text_is_named(tmp_path):
    with pytest.raises(InvalidInput, match="cannot be read"):
        read_sensitivity(tmp_path / "none.csv")
    (tmp_path / "bytes.csv").write_bytes(b"# stretch-sensitivity/1 \xff\n")
    with pytest.raises(InvalidInput, match="is no text"):
        read_sensitivity(tmp_path / "bytes.csv")
