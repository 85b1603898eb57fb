"""A serial line without a cable: the client opens one end of a pseudo terminal, the stand-in has the other."""

from __future__ import annotations

import os
import pty
import select
import threading
import tty
from collections.abc import Callable
from contextlib import suppress

from stretch_bt.hardware.emulators.faults import Faults
from stretch_bt.hardware.emulators.line import FaultyLine

__all__ = ["SerialLine"]


class SerialLine:
    """Calls `take(data, line)` for what the client sends; while the fault `drop` is shown, the line is dead."""

    def __init__(self, take: Callable[[bytes, FaultyLine], None], faults: Faults) -> None:
        self._take, self._faults = take, faults
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._ours)
        tty.setraw(self._theirs)
        #: what the client opens, such as `/dev/pts/3`
        self.path = os.ttyname(self._theirs)
        self._wake, self._woken = os.pipe()
        self._thread = threading.Thread(target=self._run, name=f"serial line {self.path}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Close both ends."""
        os.write(self._woken, b"x")
        self._thread.join()
        for end in (self._ours, self._theirs, self._wake, self._woken):
            os.close(end)

    def _run(self) -> None:
        line = FaultyLine(self._faults, self._send)
        while self._wake not in select.select([self._ours, self._wake], [], [])[0]:
            with suppress(OSError):
                data = os.read(self._ours, 4096)
                if self._faults.shown("drop") is None:
                    self._take(data, line)

    def _send(self, data: bytes) -> None:
        os.write(self._ours, data)
