"""The form of a run's tables: a line of provenance, a header, and lines of numbers.

The first line is `# `, the format and a JSON object of the table's provenance, the second the header.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.source.bounds import read_bytes
from stretch_bt.source.strict_json import read_json

__all__ = ["Form", "decoded", "digits", "text_of", "wrong"]


@dataclass(frozen=True, slots=True)
class Form:
    """A kind of table: its format, its columns and the least that some may hold, the tree that writes it, and how to mend a line."""

    format: str
    columns: tuple[str, ...]
    least: Mapping[str, float]
    tree: str
    mend: str

    def first_lines(self, provenance: Mapping[str, Any]) -> str:
        """Return the first two lines of a table."""
        told = json.dumps(provenance, sort_keys=True, allow_nan=False)
        return f"{self._mark}{told}\n{','.join(self.columns)}\n"

    def provenance(self, lines: list[str], name: str) -> Mapping[str, Any]:
        """Return the provenance of the table with these lines; `name` is how an error calls it.

        Raises
        ------
        InvalidInput
            Such a table does not begin with these two lines.
        """
        if not lines[0].startswith(self._mark):
            hint = f"name the file of a table that {self.tree} wrote"
            raise wrong(name, 1, f"a table begins with {self._mark!r}", hint)
        try:
            found = read_json(lines[0][len(self._mark) :])
        except InvalidInput as error:
            raise wrong(
                name, 1, f"what the table comes from cannot be read ({error})", "restore the first line"
            ) from None
        if not isinstance(found, dict):
            raise wrong(name, 1, "what the table comes from is a JSON object", "restore the first line")
        header = ",".join(self.columns)
        if len(lines) < 3 or lines[1].rstrip("\r") != header:
            raise wrong(name, 2, f"the header of a table is {header}", "write it as the second line")
        return found

    def number(self, column: str, text: str, name: str, line: int) -> float:
        """Return the number of a cell; raises InvalidInput where it is none that the column may hold."""
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or (column == "trial" and value != int(value)):
            kind = "whole number" if column == "trial" else "finite number"
            raise wrong(name, line, f"{column}: {text!r} is no {kind}", self.mend)
        if value < self.least.get(column, -math.inf):
            raise wrong(name, line, f"{column}: {value:g} is below {self.least[column]:g}", self.mend)
        return value

    @property
    def _mark(self) -> str:
        return f"# {self.format} "


def text_of(path: str | Path) -> str:
    """Return the text of a table's file; raises InvalidInput where it cannot be read, or is no text."""
    try:
        content = read_bytes(Path(path))
    except OSError as error:
        raise InvalidInput(f"{path}: the table cannot be read ({error.strerror}); name the file of a table") from None
    return decoded(content, path)


def decoded(content: bytes, path: str | Path) -> str:
    """Return the content of a table's file as text; raises InvalidInput where it is none."""
    try:
        return content.decode()
    except UnicodeDecodeError:
        raise InvalidInput(f"{path}: the table is no text; name the file of a table") from None


def wrong(name: str, line: int, message: str, hint: str) -> InvalidInput:
    """Return an error that names a line of a table and what to do."""
    return InvalidInput(f"{name}:{line}: {message}; {hint}")


def digits(value: float) -> str:
    """Return a number in nine digits."""
    return f"{value:.9g}"
