"""rows.jsonl: one row a line, on the disk as soon as it is there."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from stretch_bt.errors import Diagnostic, InvalidInput, RecordError
from stretch_bt.source.strict_json import read_json

__all__ = ["ROWS", "RowFile"]

ROWS = "rows.jsonl"


class RowFile:
    """A file of rows, open for one process at a time; a last line that is torn is dropped.

    Parameters
    ----------
    path
        The file, which is made where it is missing.
    whole
        Says whether a row has what its readers need, beside `key` and `status`.

    Attributes
    ----------
    statuses : dict of str to str
        By the key of each row: its status. The last row of a key counts.

    Raises
    ------
    InvalidInput
        Another sweep writes to the file, or it cannot be written.
    RecordError
        A line of it is no row.
    """

    def __init__(self, path: Path, whole: Callable[[dict[str, Any]], bool] = lambda row: True) -> None:
        self.path = path
        self._whole = whole
        self.statuses: dict[str, str] = {}
        self._places: dict[str, int] = {}
        try:
            self._file: BinaryIO = self.path.open("a+b", buffering=0)
        except OSError as error:
            raise InvalidInput(f"{self.path}: cannot write the rows: {error.strerror}; name another folder") from None
        try:
            self._lock()
            self._index()
        except BaseException:
            self.close()
            raise

    def write(self, row: Mapping[str, Any]) -> None:
        """Append a row; the operating system has it when this returns.

        Raises
        ------
        InvalidInput
            The disk takes no more.
        """
        line = json.dumps(row, allow_nan=False, ensure_ascii=False).encode() + b"\n"
        try:
            self._places[row["key"]] = self._file.seek(0, os.SEEK_END)
            while line:
                line = line[self._file.write(line) or 0 :]
        except OSError as error:
            raise InvalidInput(
                f"{self.path}: cannot write the rows: {error.strerror}; make room and go on with --resume"
            ) from None
        self.statuses[row["key"]] = row["status"]

    def rows(self, keys: Iterator[str]) -> Iterator[dict[str, Any]]:
        """Yield the row that counts for each of some keys, where there is one; reads them from the disk."""
        for key in keys:
            if key in self._places:
                self._file.seek(self._places[key])
                yield json.loads(self._line())

    def close(self) -> None:
        """Give the file free."""
        self._file.close()

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            what = "another sweep writes to this file"
            raise InvalidInput(f"{self.path}: {what}; wait for it, or name another folder") from None

    def _line(self) -> bytes:
        """Return the line that begins where the file stands."""
        parts = []
        while part := self._file.read(1 << 14):
            head, end, _ = part.partition(b"\n")
            parts.append(head + end)
            if end:
                break
        return b"".join(parts)

    def _index(self) -> None:
        place = 0
        with self.path.open("rb") as file:
            for number, line in enumerate(file, 1):
                if not line.endswith(b"\n"):
                    self._file.truncate(place)
                    return
                row = self._parsed(line, number)
                self.statuses[row["key"]], self._places[row["key"]] = row["status"], place
                place += len(line)

    def _parsed(self, line: bytes, number: int) -> dict[str, Any]:
        try:
            row = read_json(line)
        except InvalidInput:
            row = None
        known = isinstance(row, dict) and isinstance(row.get("key"), str) and isinstance(row.get("status"), str)
        if known and self._whole(row):
            return dict(row)
        hint = "remove the line, so that its item is run again"
        finding = Diagnostic(str(self.path), number, 1, "error", "rows-damaged", "this line is no row of a sweep", hint)
        raise RecordError([finding])
