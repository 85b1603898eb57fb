"""Small sweeps in a folder of their own."""

import json
import textwrap
from pathlib import Path

import pytest

from stretch_bt.runtime.sweep_check import check_sweep
from stretch_bt.sweep.items import items_of

#: needs no device and ends at once: the number, or FAILURE where it is above 3
COUNT = """\
format: stretch-tree/1
params: {number: {default: 1}}
trees:
  main:
    out: {reached: int}
    sequence:
      - wait: {duration: 0.2 s}
      - check: {that: "number <= 3", else: "$number is too much"}
      - set: {reached: "2 * number"}
"""
SWEEP = """\
format: stretch-sweep/1
tree: count.yaml
set: {number: [1, 2, 3, 4]}
"""


class Lab:
    """A folder with a sweep file."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.write("count.yaml", COUNT)
        self.write("sweep.yaml", SWEEP)

    @property
    def file(self):
        return self.folder / "sweep.yaml"

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(text))
        return path

    def sweep(self, text):
        """Write another sweep file."""
        return self.write("sweep.yaml", f"format: stretch-sweep/1\n{text}\n")

    def specs(self):
        return list(items_of(check_sweep(self.file)))


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "lab").mkdir()
    return Lab(tmp_path / "lab")


def rows_of(folder):
    """Return the rows that count, sorted by their keys, without what differs from one worker to the next."""
    lines = (folder / "rows.jsonl").read_text().splitlines()
    last = {row["key"]: row for row in map(json.loads, lines)}
    return [
        {name: value for name, value in row.items() if not name.endswith("_seconds") and name != "worker"}
        for _, row in sorted(last.items())
    ]


@pytest.fixture
def rows():
    return rows_of
