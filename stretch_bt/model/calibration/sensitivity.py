"""The table of a sensitivity map: how large known flat cylinders look at each stretch and depth, as a CSV file.

The first line is `# stretch-sensitivity/1` and a JSON object of the table's provenance, the second the header. Each press
has a line for each of `METHODS`, in their order; all of them are written at once, or the press does not count.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.form import Form, digits, text_of, wrong
from stretch_bt.model.calibration.protocol import State

__all__ = [
    "COLUMNS",
    "FORMAT",
    "METHODS",
    "NAME",
    "Found",
    "Sensed",
    "Sensitivity",
    "first_lines",
    "parse_sensitivity",
    "read_sensitivity",
    "sensed_lines",
]

FORMAT = "stretch-sensitivity/1"
#: how the table in the record of a run is called
NAME = "contact_sensitivity.csv"
#: `fit`: the joint fit of face and skirt to the contact; `paper_fit`: the same function on the paper's segmentation, given nothing else;
#: `paper_width`: the width of the contact in the paper's segmentation
METHODS = ("fit", "paper_fit", "paper_width")
COLUMNS = (
    "diameter_mm",
    "stretch_mm",
    "depth_mm",
    "trial",
    "method",
    "shape",
    "diameter_i_mm",
    "diameter_i_sd_mm",
    "diameter_j_mm",
    "diameter_j_sd_mm",
    "error_i_mm",
    "error_j_mm",
    "absolute_error_mm",
    "time_s",
    "refused",
)
_LEAST = {"diameter_mm": 0.0, "stretch_mm": -1.0, "trial": 1.0, "diameter_i_sd_mm": 0.0, "diameter_j_sd_mm": 0.0}
_FORM = Form(FORMAT, COLUMNS, _LEAST, "contact_sensitivity", "repair or remove its press")


@dataclass(frozen=True, slots=True)
class Found:
    """The finding of a method in a frame: widths along i and j with their standard deviations, m; or why it refused, then all are 0."""

    method: str
    i: float = 0.0
    i_sd: float = 0.0
    j: float = 0.0
    j_sd: float = 0.0
    shape: str = ""
    refused: str = ""

    def errors(self, diameter: float) -> tuple[float, float] | None:
        """Return by how much the widths miss a diameter, m; None where the method refused."""
        return None if self.refused else (self.i - diameter, self.j - diameter)


@dataclass(frozen=True, slots=True)
class Sensed(State):
    """A press and each method's finding, in the order of `METHODS`; `time`, s, is on the run's clock."""

    found: tuple[Found, ...]
    time: float

    def of(self, method: str) -> Found:
        """Return the finding of a method."""
        return self.found[METHODS.index(method)]


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """A table: its provenance, and its presses."""

    provenance: Mapping[str, Any]
    rows: tuple[Sensed, ...]

    def presses(self) -> Sequence[Sensed]:
        """Return the presses."""
        return self.rows


def first_lines(provenance: Mapping[str, Any]) -> str:
    """Return the first two lines of a table."""
    return _FORM.first_lines(provenance)


def sensed_lines(press: Sensed) -> str:
    """Return the lines of a press; numbers carry nine digits, and a method that refused has blank numbers."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    for found in press.found:
        where = [*(digits(1e3 * v) for v in (press.size, press.stretch, press.depth)), str(press.trial)]
        writer.writerow(
            [*where, found.method, found.shape, *_widths(found, press.size), digits(press.time), _line(found.refused)]
        )
    return out.getvalue()


def read_sensitivity(path: str | Path) -> Sensitivity:
    """Read a table.

    Raises
    ------
    InvalidInput
        The file is missing or is no table; the text names the line, and what to do.
    """
    return parse_sensitivity(text_of(path), str(path))


def parse_sensitivity(text: str, name: str = NAME) -> Sensitivity:
    """Return the table that a text holds, with the errors of `read_sensitivity`; `name` is how they call it."""
    lines = text.split("\n")
    provenance = _FORM.provenance(lines, name)
    rows = [_row(line.rstrip("\r"), name, number) for number, line in enumerate(lines[2:-1], 3)]
    if lines[-1] != "" or len(rows) % len(METHODS):
        raise wrong(
            name,
            len(lines),
            "the last press is not whole",
            "remove its lines, or run contact_sensitivity with this table, which does",
        )
    groups = [rows[k : k + len(METHODS)] for k in range(0, len(rows), len(METHODS))]
    return Sensitivity(provenance, tuple(_press(group, name, 3 + k * len(METHODS)) for k, group in enumerate(groups)))


def _widths(found: Found, diameter: float) -> list[str]:
    errors = found.errors(diameter)
    if errors is None:
        return [""] * 7
    values = (found.i, found.i_sd, found.j, found.j_sd, *errors, (abs(errors[0]) + abs(errors[1])) / 2)
    if not all(math.isfinite(v) for v in values):
        raise InvalidInput(f"a press of a table has finite numbers, got {found}")
    return [digits(1e3 * v) for v in values]


def _row(line: str, name: str, number: int) -> tuple[State, float, Found]:
    """Return the press, the time and the finding of a line, SI."""
    try:
        cells = next(csv.reader([line]), [])
    except csv.Error:
        longest = csv.field_size_limit()
        problem = f"a carriage return stands within the line, or a cell is longer than {longest} characters"
        raise wrong(name, number, problem, _FORM.mend) from None
    if len(cells) != len(COLUMNS):
        raise wrong(
            name, number, f"a row has {len(COLUMNS)} columns, this one {len(cells)}", "repair or remove its press"
        )
    given = dict(zip(COLUMNS, cells, strict=True))
    if given["method"] not in METHODS:
        raise wrong(name, number, f"method: there is no {given['method']!r}", f"write one of {', '.join(METHODS)}")
    size, stretch, depth, trial, time = (
        _FORM.number(column, given[column], name, number)
        for column in ("diameter_mm", "stretch_mm", "depth_mm", "trial", "time_s")
    )
    state = State("cylinder", size * 1e-3, stretch * 1e-3, depth * 1e-3, int(trial))
    if given["refused"]:
        return state, time, Found(given["method"], refused=given["refused"])
    widths = ("diameter_i_mm", "diameter_i_sd_mm", "diameter_j_mm", "diameter_j_sd_mm")
    i, i_sd, j, j_sd = (_FORM.number(column, given[column], name, number) * 1e-3 for column in widths)
    return state, time, Found(given["method"], i, i_sd, j, j_sd, given["shape"])


def _press(group: list[tuple[State, float, Found]], name: str, number: int) -> Sensed:
    state, time, _ = group[0]
    found = tuple(found for _, _, found in group)
    if any(other != state for other, _, _ in group) or tuple(f.method for f in found) != METHODS:
        methods = ", ".join(METHODS)
        raise wrong(name, number, f"a press has a line for each of {methods}, in this order", "repair or remove it")
    return Sensed(state.geometry, state.size, state.stretch, state.depth, state.trial, found, time)


def _line(text: str) -> str:
    return " ".join(text.split())
