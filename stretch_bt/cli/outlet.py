"""Standard output and standard error that nobody has to read: prints wait in a queue, a thread writes them."""

from __future__ import annotations

import fcntl
import io
import os
import resource
import select
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from queue import SimpleQueue  # noqa: TID251  no get of ours has a timeout, and a signal may come within put
from typing import Any, TextIO

from stretch_bt.cli.stops import stops

__all__ = ["Outlet", "Outlets", "answers", "pictures"]

#: bytes of pictures that may wait for a reader
ROOM = 1 << 16
#: bytes of one write: as much as a pipe takes as a whole, so that one sees a slow reader go on
PIECE = 4096
#: copies of standard output and standard error stand this far below the highest number, where own code closes none
BELOW = 64
#: how long a reader may take over one piece before it counts as none, s
PATIENCE = 0.25


class Outlet(io.RawIOBase):
    """A file descriptor that takes any bytes at once.

    A result waits for its reader however long it takes. A picture, which shows a run while it goes on, is dropped as a
    whole where others wait for a reader already, and in the end waits no longer than `PATIENCE`.
    """

    def __init__(self, number: int) -> None:
        self.pictures = False
        #: why it takes no more
        self.error: OSError | None = None
        self._number = number
        self._queue: SimpleQueue[bytes] = SimpleQueue()
        self._put = self._taken = self._owed = 0  # bytes since the beginning; the last up to the end of the last result
        self._thread: threading.Thread | None = None

    def writable(self) -> bool:
        """Return that one may write."""
        return True

    def fileno(self) -> int:
        """Return the file descriptor."""
        return self._number

    def isatty(self) -> bool:
        """Return whether a terminal shows it."""
        return os.isatty(self._number)

    def write(self, data: Any) -> int:
        """Take bytes; never waits."""
        taken = bytes(data)
        if self.pictures and self._put - self._taken > ROOM:
            return len(taken)
        self._put += len(taken)
        if not self.pictures:
            self._owed = self._put
        self._queue.put(taken)
        if self._thread is None:
            self._thread = threading.Thread(target=self._write_all, name=f"outlet {self._number}", daemon=True)
            self._thread.start()
        return len(taken)

    def drain(self, stopped: Callable[[], bool]) -> None:
        """Wait until all is written; gives up a reader that takes nothing where only pictures wait, or once `stopped`."""
        before, since = self._taken, time.monotonic()
        while self._taken < self._put:
            time.sleep(0.001)
            if self._taken != before:
                before, since = self._taken, time.monotonic()
            elif time.monotonic() - since > PATIENCE and (self._taken >= self._owed or stopped()):
                return

    def _write_all(self) -> None:
        while True:
            data = self._queue.get()
            for first in range(0, len(data), PIECE):
                piece = data[first : first + PIECE]
                self._write(memoryview(piece))
                self._taken += len(piece)

    def _write(self, rest: memoryview) -> None:
        while rest and self.error is None:
            try:
                rest = rest[os.write(self._number, rest) :]
            except BlockingIOError:  # whoever shares it made it so
                select.select([], [self._number], [])
            except OSError as error:
                self.error = error


class Stream(io.TextIOWrapper):
    """Text for an outlet; code that prints into it may not close it."""

    def close(self) -> None:
        """Keep it open."""
        with suppress(OSError, ValueError):
            self.flush()


class Outlets:
    """Outlets in the place of standard output and standard error, where nobody has put anything else there.

    They write to copies of the file descriptors, which nothing closes or prints into by their numbers. With `--json`
    standard output is for the document alone: everything else that is printed, also by native code, goes to standard error.
    """

    def __init__(self) -> None:
        for number in range(3):
            try:
                os.fstat(number)
            except OSError:
                os.open(os.devnull, os.O_RDWR)  # a bin for one that is closed: the lowest that is free is this one
        self._before = sys.stdout, sys.stderr
        self._out = self._err = None
        if sys.stdout is sys.__stdout__:
            sys.stdout, self._out = _outlet(1, sys.stdout)
        if sys.stderr is sys.__stderr__:
            sys.stderr, self._err = _outlet(2, sys.stderr)
        #: the stream for the document
        self.answer = answers.stream = sys.stdout
        if "--json" in sys.argv:
            if self._out is not None:
                stops.out = self._out.fileno()
                os.dup2(2, 1)
            sys.stdout = sys.stderr
            if self._err is not None:
                self._err.pictures = True  # whatever counts is in the JSON
        self._ours = sys.stdout, sys.stderr, self.answer  # own code may put others there, or none

    def close(self, stopped: Callable[[], bool]) -> OSError | None:
        """Give what was printed to its readers, put back what was there before, and return why the result was lost, if it was."""
        for stream in self._ours:
            with suppress(OSError, ValueError):
                stream.flush()
        sys.stdout, sys.stderr = self._before
        answers.stream = None
        for outlet in (self._err, self._out):
            if outlet is not None:
                outlet.drain(stopped)
        if self._out is not None and not stops.process:
            os.dup2(self._out.fileno(), 1)
            stops.out = 1
        lost = self._out.error if self._out is not None else None
        return None if isinstance(lost, BrokenPipeError) else lost  # a reader that has enough is no error


def _outlet(number: int, before: TextIO | None) -> tuple[TextIO, Outlet]:
    outlet = Outlet(_copied(number))
    encoding, errors = (before.encoding, before.errors) if before is not None else ("utf-8", "strict")
    if errors == "strict":  # a path need not be text
        errors = "backslashreplace"
    buffer = io.BufferedWriter(outlet)
    return Stream(buffer, encoding, errors, line_buffering=True, write_through=True), outlet


def _copied(number: int) -> int:
    """Return a copy of a file descriptor, high up, because code that closes all it knows of begins at the low ones."""
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    try:
        return fcntl.fcntl(number, fcntl.F_DUPFD_CLOEXEC, min(most, 1 << 16) - BELOW)
    except (OSError, ValueError):  # so few are allowed
        return os.dup(number)


class Answers:
    """Where the document of a command goes, which may be elsewhere than what it prints."""

    stream: TextIO | None = None


#: the answers of this process
answers = Answers()


@contextmanager
def pictures() -> Iterator[None]:
    """Send what is printed in this block, also by native code, to standard error, and take what comes there for pictures."""
    error = sys.stderr  # own code may put another there, or none
    outlet, out = _outlet_of(error), _outlet_of(sys.stdout)
    before = outlet is not None and outlet.pictures
    hooks = sys.excepthook, sys.unraisablehook
    room = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        if outlet is not None:
            outlet.pictures = True
        if out is not None:
            os.dup2(2, 1)
        with redirect_stdout(sys.stderr):
            yield
    finally:
        sys.stderr = error
        sys.excepthook, sys.unraisablehook = hooks  # no thread begins without the first
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, room)  # printing the result opens files
        with suppress(OSError, ValueError):
            error.flush()
        if outlet is not None:
            outlet.pictures = before
        if out is not None:
            os.dup2(out.fileno(), 1)


def _outlet_of(stream: TextIO) -> Outlet | None:
    outlet = getattr(getattr(stream, "buffer", None), "raw", None)
    return outlet if isinstance(outlet, Outlet) else None
