"""Reading events.jsonl back, held against what record.mcap says was written."""

from __future__ import annotations

import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from stretch_bt.errors import RecordError
from stretch_bt.plain_numbers import is_number
from stretch_bt.runtime.record.folder import FORMAT, damaged, refuse

__all__ = ["Mark", "Written"]

_TEXT, _OBJECT, _LIST = (str,), (dict,), (list,)
_ANY = (str, int, float, bool, list, dict, type(None))
#: the fields that readers of an event rely on
_FIELDS: dict[str, dict[str, tuple[type, ...]]] = {
    "status": {"path": _TEXT, "status": _TEXT},
    "write": {"key": _TEXT, "path": _TEXT, "value": _ANY},
    "command": {"device": _TEXT, "name": _TEXT, "arguments": _OBJECT, "owner": _TEXT},
    "motion": {"device": _TEXT, "owner": _TEXT, "state": _TEXT},
    "fault": {"device": _TEXT, "kind": _TEXT, "reason": _TEXT},
    "unanswered": {"device": _TEXT, "kind": _TEXT, "reason": _TEXT},
    "interrupt": {"why": _LIST},
}
_OPTIONAL: dict[str, tuple[type, ...]] = {
    "reason": _TEXT,
    "sd": (int, float, str),
    "cut_off": _TEXT,
    "stopping": (bool,),
}


@dataclass(frozen=True, slots=True)
class Mark:
    """How far events.jsonl reached when a tick was committed: bytes, and their CRC-32."""

    events: int
    crc32: int


class Written:
    """The lines of events.jsonl.

    Attributes
    ----------
    size : int
        Bytes that the file has.
    header : dict
        Its first line.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise refuse(path, "record-missing", "there is no such file; this folder is not a record", "name a record")
        self._data = path.read_bytes()
        self.size = len(self._data)
        first = self._data.partition(b"\n")[0]
        header, _ = _parsed(first)
        if header.get("type") != "header" or header.get("format") != FORMAT:
            raise refuse(path, "record-format", f"the first line is not the header of a {FORMAT}", "name a record")
        self.header = header

    @property
    def marked(self) -> bool:
        """Whether the recorder left marks; the first ones left none."""
        return bool(self.header.get("marks"))

    def events(self, marks: Sequence[Mark], closed: bool) -> tuple[list[dict[str, Any]], RecordError | None]:
        """Return the events that were committed, and the error that says where the file is not as it was written.

        Lines after the last mark that the file reaches belong to a tick that was cut off, unless the record was closed or more ticks follow.

        Raises
        ------
        RecordError
            A line cannot be read, or lines are gone from the end.
        """
        reached = [mark for mark in marks if mark.events <= self.size]
        changed = self._changed(reached)
        if changed is not None:
            return self._parse(self.size), changed
        last = reached[-1].events if reached else 0
        # in a killed run the events of the last tick may be missing, in a run that goes on the events of more ticks
        if len(reached) < len(marks) - (0 if closed else 1) and not self._grows():
            self._parse(self.size)
            raise self._damaged(
                self._line(last), f"from here on it is {marks[-1].events - self.size} bytes shorter than it was"
            )
        if len(reached) == len(marks) and self.size > last:
            raise self._damaged(self._line(last), "lines follow here that record.mcap does not know")
        return self._parse(last), None

    def unmarked(self) -> list[dict[str, Any]]:
        """Return the events of a file without marks, up to a last line that is cut off."""
        return self._parse(self._data.rfind(b"\n") + 1)

    def _grows(self) -> bool:
        """Whether the file has more bytes by now: its run goes on."""
        return self.path.stat().st_size > self.size

    def _changed(self, marks: Sequence[Mark]) -> RecordError | None:
        """Return the error that says between which lines the first changed byte is; None where no byte is changed."""
        crc = 0
        for before, mark in pairwise([Mark(0, 0), *marks]):
            crc = zlib.crc32(self._data[before.events : mark.events], crc)
            if crc != mark.crc32:
                first, last = self._line(before.events), self._line(mark.events - 1)
                lines = f"a line from here to line {last}" if last > first else "this line"
                return self._damaged(first, f"{lines} is not as it was written")
        return None

    def _parse(self, end: int) -> list[dict[str, Any]]:
        """Return the events of the lines up to a byte."""
        events = []
        for number, line in enumerate(self._data[:end].splitlines(keepends=True)[1:], 2):
            event, wrong = _parsed(line[:-1]) if line.endswith(b"\n") else ({}, "is cut off")
            wrong = wrong or _misses(event)
            if wrong:
                raise self._damaged(number, f"this line {wrong}")
            events.append(event)
        return events

    def _line(self, byte: int) -> int:
        """Return the number of the line that a byte is in, from 1."""
        return self._data.count(b"\n", 0, byte) + 1

    def _damaged(self, line: int, message: str) -> RecordError:
        return damaged(self.path, message, line)


def _parsed(line: bytes) -> tuple[dict[str, Any], str]:
    """Return a JSON object and nothing, or an empty one and what is wrong."""
    try:
        event = json.loads(line)
    except (ValueError, RecursionError):
        return {}, "is not JSON"
    return (event, "") if isinstance(event, dict) else ({}, "is not a JSON object")


def _misses(event: dict[str, Any]) -> str:
    """Return what an event lacks of what its readers rely on, or nothing."""
    kind, tick, time = (event.get(name) for name in ("type", "tick", "time"))
    if not isinstance(kind, str) or type(tick) is not int or not is_number(time):
        return "has no type, tick or time"
    wanted = {**_FIELDS.get(kind, {}), **{name: types for name, types in _OPTIONAL.items() if name in event}}
    wrong = [name for name, types in wanted.items() if name not in event or not isinstance(event[name], types)]
    return f"has no {wrong[0]!r} that a {kind} has" if wrong else ""
