"""What docs/trust.md says of bounds is what the code has."""

from pathlib import Path

from stretch_bt.source import bounds, compose, read

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "trust.md").read_text("utf-8")


def test_the_bounds_of_files_are_those_of_the_page():
    values = f"{compose.MAX_NODES:,}".replace(",", " ")
    assert (
        f"| {read.MAX_BYTES // 1_000_000} MB, {values} values with anchors expanded, {compose.MAX_DEPTH} levels |"
        in PAGE
    )
    assert f"used together | {bounds.MAX_ARRAYS >> 30} GiB |" in PAGE
    assert bounds.MAX_IMAGE == bounds.MAX_FORM == bounds.MAX_CHUNK
    assert PAGE.count(f"| {bounds.MAX_CHUNK >> 20} MiB |") == 2
