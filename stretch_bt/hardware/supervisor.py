"""The process that keeps a device, as the driver sees it: begun, listened to, ended; its loss stays."""

from __future__ import annotations

import itertools
import select
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass

from stretch_bt.errors import DeviceLost, MissingExtra, named, writable
from stretch_bt.hardware.channel import ChannelClosed, OtherSideGone
from stretch_bt.hardware.child import Child
from stretch_bt.hardware.latched import Latched
from stretch_bt.hardware.messages import Answer, Codec, Lost, Message, Request

__all__ = ["Deadlines", "ProcessProgram", "Supervisor"]

_BEAT = 0.05
#: how long the thread may take to hear why a process ended that takes no messages, s
_GOING = 0.5
#: silence after which a process that is to end counts as one that hangs, s
_HANGS = 0.5


@dataclass(frozen=True)
class ProcessProgram:
    """What runs in the process: a module, its messages, the first of them, and files that it inherits."""

    module: str
    codec: Codec
    first: Sequence[Message]
    descriptors: Sequence[int] = ()


@dataclass(frozen=True)
class Deadlines:
    """How long the process may take to open the device, be silent after that, and end, s."""

    opening: float
    silence: float
    ending: float


class Supervisor(Latched):
    """Keeps one process that keeps one device, from a thread of its own.

    Parameters
    ----------
    name
        The device, for messages.
    program
        What the process is.
    deadlines
        How long it may take.
    take
        Called in the thread with each message that is no answer; returns whether the device is open with it.
    beat
        Returns the message that the process gets every 0.05 s as a sign of life, if any.
    after
        Called in the thread once the process is gone.
    remark
        Returns what is said besides of a loss.
    """

    def __init__(
        self,
        name: str,
        program: ProcessProgram,
        deadlines: Deadlines,
        *,
        take: Callable[[Message], bool],
        beat: Callable[[], Message | None] = lambda: None,
        after: Callable[[], None] = lambda: None,
        remark: Callable[[], str] = lambda: "",
    ) -> None:
        super().__init__(name, remark)
        self._program, self._deadlines = program, deadlines
        self._take, self._beat, self._after = take, beat, after
        self._ending, self._started = threading.Event(), threading.Event()
        self._child: Child | None = None
        self._numbers = itertools.count(1)
        self._waiting: dict[int, Future[Answer]] = {}
        self._heard = 0.0
        #: until when the process may be silent, by the monotonic clock, s
        self._excused = 0.0
        self._failed: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=f"supervisor of {name}", daemon=True)

    @property
    def pid(self) -> int | None:
        """Number of the process, while there is one."""
        child = self._child
        return None if child is None else child.pid

    def start(self) -> None:
        """Begin the process and wait until the device is open; raises DeviceLost where it does not open, and then nothing is left."""
        self._thread.start()
        try:
            if not self._started.wait(self._deadlines.opening + 1.0):
                self._failed = ChannelClosed("it was not open in time")
        except BaseException:  # such as Ctrl-C: nobody will end it later
            self.end()
            raise
        if self._failed is not None:
            self.end()
            if isinstance(self._failed, MissingExtra):
                raise self._failed
            raise DeviceLost(self.name, str(self._failed)) from self._failed

    def end(self) -> None:
        """End the process and the thread; returns when `after` was called."""
        self._ending.set()
        if self._thread.ident is not None:
            self._thread.join()

    def wait_for_end(self) -> None:
        """Wait after a loss until `after` was called."""
        if self._lost is not None:
            self._thread.join()

    def number(self) -> int:
        """Return a number that no other request has."""
        return next(self._numbers)

    def send(self, message: Message) -> None:
        """Send a message; raises DeviceLost."""
        self.check_connected()
        child = self._child
        try:
            if child is None:
                raise ChannelClosed("there is no process")
            child.channel.send(message)
        except ChannelClosed as error:
            if isinstance(error, OtherSideGone):
                self._thread.join(_GOING)  # it hears why
            self._latch(str(error))
            self.kill()
            self.check_connected()

    def reply(self, message: Message | None) -> None:
        """Send a message, if any, from the thread; where it cannot be sent, the last messages of the process are heard first."""
        with suppress(ChannelClosed):
            if message is not None and self._child is not None:
                self._child.channel.send(message)

    def ask(self, request: Request, within: float, *, quiet: bool = False) -> Answer:
        """Send a request and return the answer to it.

        Parameters
        ----------
        request
            With a number of its own.
        within
            How long the answer may take, s.
        quiet
            Whether the process may be silent as long as that.

        Raises
        ------
        DeviceLost
            None came in time, which ends the process, or the process was lost.
        """
        future = self._waiting[request.number] = Future[Answer]()
        if quiet:
            self._excused = time.monotonic() + within
        try:
            self.send(request)
            return future.result(within)
        except TimeoutError:
            self._latch(f"its process did not answer within {within:.3g} s")
            self.kill()
        except ChannelClosed as error:
            self._latch(str(error))
        finally:
            self._waiting.pop(request.number, None)
            if quiet:
                self._heard, self._excused = time.monotonic(), 0.0
        self.check_connected()
        raise AssertionError("not reached")

    def kill(self) -> None:
        """End the process at once."""
        child = self._child
        if child is not None:
            child.kill()

    def _run(self) -> None:
        try:
            self._child = Child(
                self._program.module, self._program.codec, self._program.first, self._program.descriptors
            )
            self._heard = time.monotonic()
            self._serve(self._child)
        except Exception as error:  # whatever breaks is a loss of the device, never of the thread
            self._lose(error)
        finally:
            self._refuse_requests()
            self._reap()
            self._started.set()

    def _reap(self) -> None:
        """Leave no process: one that was not lost, and is not silent, has a moment to leave its device."""
        child = self._child
        if child is not None:
            for message in child.end(self._grace()):
                with suppress(Exception):  # what it says of a loss comes too late
                    self._hear(message)
        self._child = None
        self._after()

    def _grace(self) -> float:
        """Return how long the process may take to end, s: one that hangs would not use its time."""
        hangs = time.monotonic() > max(self._heard + _HANGS, self._excused)
        return 0.0 if self._lost is not None or not self._started.is_set() or hangs else self._deadlines.ending

    def _serve(self, child: Child) -> None:
        due = 0.0
        while not self._ending.is_set() and self._lost is None:
            now = time.monotonic()
            if now >= due:
                due = now + _BEAT
                self.reply(self._beat())
            if select.select([child.channel], [], [], _BEAT)[0]:
                for message in child.channel.drain():
                    self._heard = time.monotonic()
                    self._hear(message)
            self._check_silence(child)

    def _hear(self, message: Message) -> None:
        if isinstance(message, Lost):
            if message.missing:
                raise MissingExtra(f"{self.name} needs {message.reason}")
            raise ChannelClosed(message.reason)
        if isinstance(message, Answer):
            future = self._waiting.get(message.number)
            with suppress(InvalidStateError):
                if future is not None:
                    future.set_result(message)
        elif self._take(message):
            self._started.set()

    def _check_silence(self, child: Child) -> None:
        now = time.monotonic()
        silent = now - self._heard
        longest = self._deadlines.silence if self._started.is_set() else self._deadlines.opening
        if silent > longest and now > self._excused and not select.select([child.channel], [], [], 0.0)[0]:
            raise ChannelClosed(f"its process gave no sign of life for {silent:.2g} s")

    def _lose(self, error: Exception) -> None:
        """Write down a loss, and refuse what waits for an answer."""
        if self._ending.is_set():
            return
        reason = self._why(error)
        if not self._started.is_set():
            self._failed = error if isinstance(error, MissingExtra) else ChannelClosed(reason)
        self._latch(reason)

    def _refuse_requests(self) -> None:
        for future in list(self._waiting.values()):
            with suppress(InvalidStateError):
                future.set_exception(ChannelClosed(self._lost or "its process ended"))

    def _why(self, error: Exception) -> str:
        """Return why the process ended, from what it said or how it ended."""
        if isinstance(error, ChannelClosed) and self._child is not None:
            return self._child.why(error)
        return writable(error) if isinstance(error, OSError) else named(error)
