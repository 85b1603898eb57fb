"""What a signal does to a command, from the first line of `main` to its exit."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable
from contextlib import suppress

__all__ = ["EXIT_INTERRUPTED", "Stops", "stops"]

EXIT_INTERRUPTED = 130

#: how long whoever reads standard output may keep a process that is to stop, s
PATIENCE = 0.25

# json is not imported yet, and a handler imports nothing
_RUN = """\
{
  "status": "INTERRUPTED",
  "reason": "stopped by NAME before the first tick",
  "outputs": {},
  "truth": {},
  "ticks": 0,
  "task_seconds": 0.0,
  "wall_seconds": 0.0,
  "cpu_seconds": 0.0,
  "record": null,
  "diagnostics": []
}
"""
_OTHER = """\
{
  "error": "Interrupted",
  "reason": "stopped by NAME"
}
"""


class Stops:
    """Takes the signals of a command, in one of three ways, and keeps their names.

    While nothing is open yet, the process ends in the handler: an exception that a handler raises may be lost in what
    is being imported. While a command is at work it raises KeyboardInterrupt, so that the command closes what it
    opened. Once a run ends by itself, or the result is being given, a signal is only noted.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        #: whether the result has been given
        self.told = False
        #: whether the process is ours to end
        self.process = False
        self._way: Callable[[str], None] = self._end

    def __call__(self, name: str) -> None:
        """Take a signal."""
        self.names.append(name)
        self._way(name)

    def begin(self, *, process: bool) -> None:
        """Begin a command: a signal ends it at once, and the process too where that is ours to end."""
        self.names.clear()
        self.told = False
        self.process = process
        self._way = self._end

    def work(self) -> None:
        """From now on a signal raises KeyboardInterrupt."""
        self._way = self._raise

    def note(self) -> None:
        """From now on a signal is only noted."""
        self._way = _nothing

    @property
    def noting(self) -> bool:
        """Whether a signal is only noted."""
        return self._way is _nothing

    def document(self) -> str:
        """Return the JSON of a command that was stopped before it had any other to give."""
        text = _RUN if sys.argv[1:2] == ["run"] else _OTHER
        return text.replace("NAME", self.names[0] if self.names else "SIGINT")

    def say(self, text: str) -> None:
        """Write a short text to standard error, unless that is closed or would wait for its reader."""
        _give(2, text, 0.0)

    def _raise(self, name: str) -> None:
        raise KeyboardInterrupt(name)

    def _end(self, name: str) -> None:
        if not self.process:
            raise KeyboardInterrupt(name)
        if "--json" in sys.argv:
            _give(1, self.document(), PATIENCE)
        _give(2, f"stopped by {name} before anything began\n", 0.0)
        os._exit(EXIT_INTERRUPTED)


def _nothing(name: str) -> None:
    """Leave it at the note."""


def _give(number: int, text: str, patience: float) -> None:
    """Write a short text to a file descriptor, unless that would wait for its reader."""
    with suppress(OSError):
        poll = select.poll()
        poll.register(number, select.POLLOUT)
        if poll.poll(patience * 1e3):
            os.write(number, text.encode())


#: of this process
stops = Stops()
