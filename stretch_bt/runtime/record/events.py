"""events.jsonl: one line of compact JSON for each thing that happened, the log that two runs are compared by."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stretch_bt.runtime.record.folder import FORMAT
from stretch_bt.runtime.record.plain import dumps
from stretch_bt.runtime.record.spool import Spool

__all__ = ["EventLog"]


class EventLog:
    """Writes a header, plain already, and events; lines reach the disk at `commit`.

    Parameters
    ----------
    beside
        Whether record.mcap is written beside it, which marks how far this file reaches.

    Attributes
    ----------
    size, crc32 : int
        Bytes of all lines so far and their CRC-32, committed or not.
    """

    def __init__(self, path: Path, header: Mapping[str, Any], *, beside: bool) -> None:
        self._spool = Spool(path)
        self.size = self.crc32 = 0
        own = {"marks": True} if beside else {"readings": False}
        self.event({**header, "type": "header", "format": FORMAT, **own})

    def event(self, fields: Mapping[str, Any]) -> None:
        """Append an event; its fields are plain already."""
        line = dumps(fields) + b"\n"
        self.size += len(line)
        self.crc32 = zlib.crc32(line, self.crc32)
        self._spool.write(line)

    def commit(self) -> None:
        """Hand the lines so far to the operating system."""
        self._spool.commit()

    def close(self) -> None:
        """Commit and close."""
        self._spool.close()

    def abandon(self) -> None:
        """Close without writing anything more."""
        self._spool.abandon()
