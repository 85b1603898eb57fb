"""The table of a characterisation: forces of known indenters by stretch and depth, as a CSV file with units and provenance.

The first line is `# stretch-characterization/1` and a JSON object of the table's provenance, the second the header; each
other line is one press, blank where a column does not apply. A row is written whole, with its line end, or does not count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_path
from stretch_bt.errors import InvalidInput
from stretch_bt.model.calibration.form import Form, digits, text_of, wrong
from stretch_bt.model.calibration.protocol import State

__all__ = [
    "COLUMNS",
    "FORMAT",
    "NAME",
    "PressRow",
    "Table",
    "as_table",
    "first_lines",
    "parse_table",
    "read_table",
    "table_line",
]

FORMAT = "stretch-characterization/1"
#: how the table in the record of a run is called
NAME = "characterization.csv"
COLUMNS = (
    "geometry",
    "diameter_mm",
    "angle_deg",
    "stretch_mm",
    "depth_mm",
    "trial",
    "force_N",
    "force_sd_N",
    "contact_height_mm",
    "time_s",
)
_GEOMETRIES = ("sphere", "cylinder", "cone")
MOST_TRIALS = 1e9
_LEAST = {"force_sd_N": 0.0, "trial": 1.0, "stretch_mm": -1.0, "diameter_mm": 0.0, "angle_deg": 0.0}
_FORM = Form(FORMAT, COLUMNS, _LEAST, "characterize", "repair or remove the row")

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PressRow(State):
    """One row, SI: a state, the force on the hand along its axis, the world height of first contact, and when it was measured."""

    force: float
    force_sd: float
    contact_height: float
    time: float


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table by columns, each (n,), SI; `size` is a diameter, m, and for a cone an angle, rad.

    `depth` is how far the hand is past the first contact that the camera found after the indenter was mounted, at stretch 0, and
    `contact_height` the height of that contact: one error of height is common to all rows that share it. `force` is the mean of
    readings along the hand's axis, `force_sd` its standard error, which includes the zero's.
    """

    provenance: Mapping[str, Any]
    geometry: npt.NDArray[np.str_]
    size: Array
    stretch: Array
    depth: Array
    trial: npt.NDArray[np.int64]
    force: Array
    force_sd: Array
    contact_height: Array
    time: Array

    def __len__(self) -> int:
        return int(self.force.size)

    def presses(self) -> Iterator[PressRow]:
        """Yield the rows one by one."""
        columns = [getattr(self, field.name).tolist() for field in fields(self)[1:]]
        for row in zip(*columns, strict=True):
            yield PressRow(*row)


def first_lines(provenance: Mapping[str, Any]) -> str:
    """Return the first two lines of a table."""
    return _FORM.first_lines(provenance)


def table_line(press: PressRow) -> str:
    """Return the line of a press; numbers carry nine digits."""
    values = (press.force, press.force_sd, press.contact_height * 1e3, press.time)
    if not all(math.isfinite(v) for v in (*values, press.size, press.stretch, press.depth)):
        raise InvalidInput(f"a press of a table has finite numbers, got {press}")
    cone = press.geometry == "cone"
    sizes = ("", digits(math.degrees(press.size))) if cone else (digits(press.size * 1e3), "")
    where = (digits(press.stretch * 1e3), digits(press.depth * 1e3), str(press.trial))
    return ",".join((press.geometry, *sizes, *where, *(digits(v) for v in values))) + "\n"


def read_table(path: str | Path) -> Table:
    """Read a table.

    Raises
    ------
    InvalidInput
        The file is missing or is no table; the text names the line, and what to do.
    """
    check_path(path)
    return parse_table(text_of(path), str(path))


def parse_table(text: str, name: str = NAME) -> Table:
    """Return the table that a text holds, with the errors of `read_table`; `name` is how they call it."""
    lines = text.split("\n")
    provenance = _FORM.provenance(lines, name)
    if lines[-1] != "":
        raise wrong(
            name,
            len(lines),
            "the last line has no line end, so that it may be cut short",
            "remove the line, or run characterize with this table, which does",
        )
    rows = [_press(line.rstrip("\r"), name, number) for number, line in enumerate(lines[2:-1], 3)]
    return as_table(provenance, rows)


def as_table(provenance: Mapping[str, Any], presses: list[PressRow]) -> Table:
    """Return presses as a table."""
    columns = list(zip(*map(astuple, presses), strict=True)) or [() for _ in fields(PressRow)]
    kinds = [np.str_, float, float, float, np.int64, float, float, float, float]
    return Table(provenance, *(np.array(c, dtype=kind) for c, kind in zip(columns, kinds, strict=True)))


def _press(line: str, name: str, number: int) -> PressRow:
    """Return the press of a line, SI."""
    given = line.split(",")
    if len(given) != len(COLUMNS):
        raise wrong(name, number, f"a row has {len(COLUMNS)} columns, this one {len(given)}", "repair or remove it")
    geometry, *numbers = given
    if geometry not in _GEOMETRIES:
        raise wrong(name, number, f"geometry: there is no {geometry!r}", f"write one of {', '.join(_GEOMETRIES)}")
    blank = "diameter_mm" if geometry == "cone" else "angle_deg"
    found = {c: _number(t, c, c == blank, name, number) for c, t in zip(COLUMNS[1:], numbers, strict=True)}
    if not max(found["diameter_mm"], found["angle_deg"]) > 0:
        raise wrong(name, number, "the size of the indenter is 0", _FORM.mend)
    if found["trial"] > MOST_TRIALS:
        raise wrong(name, number, f"trial: {found['trial']:g} is above {MOST_TRIALS:g}", _FORM.mend)
    size = math.radians(found["angle_deg"]) if geometry == "cone" else found["diameter_mm"] * 1e-3
    return PressRow(
        geometry,
        size,
        found["stretch_mm"] * 1e-3,
        found["depth_mm"] * 1e-3,
        int(found["trial"]),
        found["force_N"],
        found["force_sd_N"],
        found["contact_height_mm"] * 1e-3,
        found["time_s"],
    )


def _number(text: str, column: str, blank: bool, name: str, number: int) -> float:
    """Return the number of a cell, 0 for one that is blank as it has to be."""
    if blank and text == "":
        return 0.0
    if blank:
        raise wrong(name, number, f"{column}: {text!r} stands where this geometry has none", "leave it blank")
    return _FORM.number(column, text, name, number)
