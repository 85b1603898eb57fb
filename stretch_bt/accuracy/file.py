"""Rows in a file of JSON lines, whose first line says its format."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from stretch_bt.accuracy.points import STATUSES, Cost, Row, Setting
from stretch_bt.accuracy.registry import names
from stretch_bt.errors import InvalidInput
from stretch_bt.source.strict_json import no_number

__all__ = ["FORMAT", "merged", "read", "write"]

FORMAT = "stretch-accuracy/2"
_FIELDS = {field.name for field in fields(Row)}
_NEEDED = {field.name for field in fields(Row) if field.default is MISSING}


def write(path: Path, rows: Iterable[Row]) -> None:
    """Write rows, one a line, after a line with the format."""
    lines = [{"format": FORMAT}, *(row.to_json() for row in rows)]
    text = "".join(
        json.dumps(line, allow_nan=False, ensure_ascii=False, separators=(",", ":")) + "\n" for line in lines
    )
    path.write_text(text, encoding="utf-8")


def read(path: Path) -> list[Row]:
    """Return the rows of a file.

    Raises
    ------
    InvalidInput
        The file cannot be read, or a line of it is no row; the text names it.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    head = _object(path, 1, lines[0] if lines else "")
    if head.get("format") != FORMAT:
        raise InvalidInput(f'{path}:1: a file of rows begins with {{"format": "{FORMAT}"}}, not with {head}')
    known = names()
    return [_row(path, number, line, known) for number, line in enumerate(lines[1:], 2) if line.strip()]


def merged(rows: Iterable[Row]) -> list[Row]:
    """Return the last row of each key, where the first of it stood, domain by domain."""
    found: dict[Any, Row] = {}
    for row in rows:
        found[row.key] = row
    return sorted(found.values(), key=lambda row: row.domain)


def _object(path: Path, number: int, line: str) -> dict[str, Any]:
    try:
        found = json.loads(line, parse_constant=no_number)
    except ValueError as error:
        raise InvalidInput(f"{path}:{number}: this is no line of JSON: {error}") from None
    if not isinstance(found, dict):
        raise InvalidInput(f"{path}:{number}: a row is a JSON object, not {line[:60]}")
    return found


def _row(path: Path, number: int, line: str, known: list[str]) -> Row:
    found = _object(path, number, line)
    wrong = next(_wrong(found, known), None)
    if wrong is not None:
        raise InvalidInput(f"{path}:{number}: {wrong}")
    cost = found["cost"]
    found |= {"setting": Setting(**found["setting"]), "cost": None if cost is None else Cost(**cost)}
    return Row(**found)


def _wrong(found: dict[str, Any], known: list[str]) -> Iterator[str]:
    """Yield the reasons why an object is no row."""
    for name in sorted(_NEEDED - found.keys()):
        yield f"the row has no {name!r}"
    for name in sorted(found.keys() - _FIELDS):
        yield f"a row has no {name!r}"
    if found["domain"] not in known:
        yield f"there is no accuracy domain {found['domain']!r}; the domains are {', '.join(known)}"
    if found["status"] not in STATUSES:
        yield f"a status is one of {', '.join(STATUSES)}, not {found['status']!r}"
    if not (isinstance(found["setting"], dict) and found["setting"].keys() == {*Setting._fields}):
        yield f"a setting has {' and '.join(Setting._fields)}, not {found['setting']!r}"
    if not (found["cost"] is None or (isinstance(found["cost"], dict) and found["cost"].keys() == {*Cost._fields})):
        yield f"a cost is null or has {', '.join(Cost._fields)}, not {found['cost']!r}"
    for name in ("error", "reference_error", "cpu_seconds", "robot_seconds", "kernel_seconds"):
        if not isinstance(found.get(name), int | float | None) or isinstance(found.get(name), bool):
            yield f"{name} is a number or null, not {found[name]!r}"
