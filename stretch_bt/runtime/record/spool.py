"""A file that is written at the boundaries of ticks: bytes that a tick appends wait in memory until `commit`."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

__all__ = ["Spool"]


class Spool:
    """A new file at `path`, with the part of a stream that an MCAP writer asks for.

    No call but `commit` and `close` touches the disk, so a full disk shows at the end of a tick and not within a node.
    """

    def __init__(self, path: Path) -> None:
        self._file: BinaryIO = path.open("xb", buffering=0)
        self._waiting: list[bytes] = []
        self._end = 0

    def write(self, data: bytes) -> int:
        """Append bytes."""
        self._waiting.append(bytes(data))
        self._end += len(data)
        return len(data)

    def tell(self) -> int:
        """Return the size of the file once everything is committed."""
        return self._end

    def flush(self) -> None:
        """Do nothing: only `commit` writes."""

    def commit(self) -> None:
        """Hand everything that waits to the operating system, so that it outlives this process."""
        rest = memoryview(b"".join(self._waiting))
        self._waiting.clear()
        while rest:
            rest = rest[self._file.write(rest) :]

    def close(self) -> None:
        """Commit and close; may be called more than once."""
        if self._file.closed:
            return
        try:
            self.commit()
        finally:
            self._file.close()

    def abandon(self) -> None:
        """Close and drop what waits, so that nothing follows a write that failed half way."""
        self._waiting.clear()
        self._file.close()
