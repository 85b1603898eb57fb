"""What a signal does to a command, from the first line of `main` to its exit."""

from __future__ import annotations

import os
import select
import sys

TYPE_CHECKING = False  # see stretch_bt/__init__.py
if TYPE_CHECKING:
    from typing import Literal

__all__ = ["EXIT_BAD_INPUT", "EXIT_INTERRUPTED", "Stops", "stops"]

EXIT_BAD_INPUT, EXIT_INTERRUPTED = 2, 130

#: how long whoever reads standard output may keep a process that is to stop, s
PATIENCE = 0.25

_ON_STDERR = "standard error says why"
# json is not imported yet, and a handler imports nothing
_RUN = """\
{
  "status": "STATUS",
  "reason": "REASON",
  "outputs": {},
  "truth": {},
  "ticks": 0,
  "task_seconds": 0.0,
  "wall_seconds": 0.0,
  "cpu_seconds": 0.0,
  "record": null,
  "overruns": 0,
  "errors": [],
  "unmet": [],
  "notes": [],
  "readings": {},
  "broken": [],
  "choice": null,
  "diagnostics": []
}
"""
_OTHER = """\
{
  "error": "STATUS",
  "reason": "REASON"
}
"""


class Stops:
    """Takes the signals of a command, in one of three ways, and keeps their names.

    While nothing is open yet, the process ends in the handler: an exception that a handler raises may be lost in what
    is being imported. While a command is at work it raises KeyboardInterrupt, so that the command closes what it
    opened. Once a run ends by itself, or the result is being given, a signal is only noted.

    `way` is set without a call: the interpreter looks at signals as a call begins and ends, so one that came before is
    never raised behind an `except KeyboardInterrupt` whose first line sets it.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        #: whether the result has been given
        self.told = False
        #: whether the process is ours to end
        self.process = False
        self.way: Literal["end", "raise", "note"] = "end"
        #: file descriptor that the JSON goes to
        self.out = 1
        #: why the command was refused, where standard error alone says so
        self.reason = _ON_STDERR

    def __call__(self, name: str) -> None:
        """Take a signal."""
        self.names.append(name)
        if self.way == "end":
            self._end(name)
        elif self.way == "raise":
            raise KeyboardInterrupt(name)

    def begin(self, *, process: bool) -> None:
        """Begin a command: a signal ends it at once, and the process too where that is ours to end."""
        self.names.clear()
        self.told = False
        self.reason = _ON_STDERR
        self.process = process
        self.way = "end"

    @property
    def name(self) -> str:
        """What stopped the command: the first signal, or code that raised what a signal raises."""
        return self.names[0] if self.names else "KeyboardInterrupt"

    def document(self) -> str:
        """Return the JSON of a command that was stopped before it had any other to give."""
        if sys.argv[1:2] == ["run"]:
            return _filled(_RUN, "INTERRUPTED", f"stopped by {self.name} before the first tick")
        return _filled(_OTHER, "Interrupted", f"stopped by {self.name}")

    def refusal(self, code: int) -> str:
        """Return the JSON of a command that ended with an exit code, and said why on standard error alone."""
        import json

        kind = "InvalidInput" if code == EXIT_BAD_INPUT else "Aborted"
        form, status = (_RUN, "ERROR") if sys.argv[1:2] == ["run"] else (_OTHER, kind)
        return _filled(form, status, json.dumps(self.reason)[1:-1])

    def say(self, text: str) -> None:
        """Write a short text to standard error, unless that is closed or would wait for its reader."""
        _give(2, text, 0.0)

    def _end(self, name: str) -> None:
        if not self.process:
            raise KeyboardInterrupt(name)
        if "--json" in sys.argv:
            _give(self.out, self.document(), PATIENCE)
        _give(2, f"stopped by {name} before anything began\n", 0.0)
        os._exit(EXIT_INTERRUPTED)


def _filled(form: str, status: str, reason: str) -> str:
    return form.replace("STATUS", status).replace("REASON", reason)


def _give(number: int, text: str, patience: float) -> None:
    """Write a short text to a file descriptor, unless that would wait for its reader."""
    try:
        poll = select.poll()
        poll.register(number, select.POLLOUT)
        if poll.poll(patience * 1e3):
            os.write(number, text.encode())
    except OSError:
        pass


#: the stops of this process
stops = Stops()
