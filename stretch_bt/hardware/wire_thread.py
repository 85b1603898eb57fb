"""One thread that has a wire to itself: clients of field devices are not safe to share, and some devices must be polled."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, Queue
from typing import Any, Generic, Protocol, TypeVar

from stretch_bt.blame import place_of_thread
from stretch_bt.errors import DeviceFault, DeviceLost, writable
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.latched import Latched

__all__ = ["Sample", "Wire", "WireClosed", "WireError", "WireThread", "WrongAnswer"]


class WireError(OSError):
    """An exchange failed: no answer, a broken one, or one to another question."""


class WrongAnswer(WireError):
    """The device answered, and not as it should by what is set for it; the message says what to check."""


class WireClosed(WireError):
    """The other side closed the connection, or broke it."""


S = TypeVar("S")
S_co = TypeVar("S_co", covariant=True)
W = TypeVar("W", bound="Wire[Any]")
R = TypeVar("R")
V = TypeVar("V")


class Wire(Protocol[S_co]):
    """A connection that one thread uses; every call ends within its deadline and raises OSError when it fails."""

    def connect(self) -> None:
        """Connect; moves nothing."""

    def read(self) -> S_co:
        """Return the device's answer about itself now."""

    def close(self) -> None:
        """Disconnect; may be called more than once."""


@dataclass(frozen=True, slots=True)
class Sample(Generic[S]):
    """An answer of a device, the host's time at which it was asked, s, and the number of the exchange."""

    value: S
    time: float
    number: int

    def reading(self, value: V) -> Reading[V]:
        """Return the reading of a value that was computed from this sample."""
        return Reading(value, self.time, self.time, self.number)


_Job = tuple["Future[Any]", Callable[[Any], Any]]


class WireThread(Latched, Generic[W, S]):
    """Polls a wire and runs commands between the polls, until the wire is lost; a loss stays.

    Parameters
    ----------
    name
        The device, for messages.
    wire
        What the thread has to itself; nothing else may use it.
    period
        Time between polls, s.
    deadline
        The longest time that a command may take, s; also how long the device may stay silent.
    now
        The clock of the run, s.
    after_poll
        Called in the thread with the wire and each new sample.
    at_loss
        Called in the thread once after a loss, with the wire connected anew where that is possible: to stop what moves.
    hint
        What a person can do about a device that takes longer than the deadline, for messages.
    """

    def __init__(
        self,
        name: str,
        wire: W,
        *,
        period: float,
        deadline: float,
        now: Callable[[], float],
        after_poll: Callable[[W, Sample[S]], None] | None = None,
        at_loss: Callable[[W], None] | None = None,
        hint: str = "",
    ) -> None:
        super().__init__(name)
        self._wire = wire
        self._period, self._deadline, self._now = period, deadline, now
        self._after_poll, self._at_loss = after_poll, at_loss
        self._hint = f"; {hint}" if hint else ""
        self._jobs: Queue[_Job | None] = Queue()
        self._ending = threading.Event()
        self._started = threading.Event()
        self._sample: Sample[S] | None = None
        self._heard = 0.0
        self._failed: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=f"wire of {name}", daemon=True)

    def start(self) -> None:
        """Connect and read once; raises DeviceLost when that fails, and then nothing is left."""
        self._thread.start()
        try:
            if not self._started.wait(self._deadline):
                hangs = f": it {at}" if (at := self._hangs()) else ""
                self._failed = WireError(f"no answer within {self._deadline:.3g} s{hangs}{self._hint}")
        except BaseException:  # such as Ctrl-C: nobody will end it later
            self._ending.set()
            self._jobs.put(None)
            raise
        if self._failed is not None:
            with suppress(DeviceFault):  # that it hangs is said already
                self.end()
            if isinstance(self._failed, OSError):
                what = "answers" if isinstance(self._failed, WrongAnswer) else "does not answer"
                raise DeviceLost(self.name, f"it {what} ({self._failed})") from self._failed
            raise self._failed

    def end(self) -> None:
        """Disconnect and end the thread.

        Raises
        ------
        DeviceFault
            It hangs in a call for longer than the deadline: it is left behind with the connection, which it closes when the call returns.
        """
        self._ending.set()
        self._jobs.put(None)
        self._thread.join(self._deadline)
        if self._thread.is_alive():
            hint = f"give every call of {type(self._wire).__name__} a time limit"
            at = self._hangs() or "goes on"
            raise DeviceFault(self.name, f"its thread {at} {self._deadline:.3g} s after it was to end; {hint}")

    def wait_for_end(self) -> None:
        """Wait after a loss until nothing is sent any more."""
        self._thread.join(self._deadline)

    def latest(self) -> Sample[S]:
        """Return the latest sample; raises DeviceLost after a loss."""
        self.check_connected()
        silent = time.monotonic() - self._heard
        if silent > self._deadline:
            self._latch(f"no answer for {silent:.2g} s{self._hint}")
            self.check_connected()
        assert self._sample is not None
        return self._sample

    @property
    def deadline(self) -> float:
        """How long a job may take, s."""
        return self._deadline

    def refresh(self) -> Sample[S]:
        """Poll now, and return the sample."""
        return self.do(lambda _: self._poll())

    def do(self, job: Callable[[W], R]) -> R:
        """Run a job on the wire, in the thread, before the next poll.

        Raises
        ------
        DeviceLost
            The connection was lost or breaks, or the job is not done within the deadline, which is a loss too; then it will not be
            begun later.
        """
        if not self._thread.is_alive():
            self._latch("closed")
        self.check_connected()
        future: Future[R] = Future()
        self._jobs.put((future, job))
        try:
            return future.result(self._deadline)
        except WireError as error:
            self._latch(str(error))
        except TimeoutError:
            future.cancel()
            self._latch(f"a command was not answered within {self._deadline:.3g} s{self._hint}")
        except BaseException:
            future.cancel()
            raise
        self.check_connected()
        raise AssertionError("not reached")

    def _hangs(self) -> str:
        """Return in which line the thread is, or nothing."""
        at = place_of_thread(self._thread)
        return f"hangs in {at}" if at else ""

    def _run(self) -> None:
        try:
            self._serve()
        except Exception as error:  # whatever breaks in a client is a loss of the device, never of the thread
            self._lose(error)
        finally:
            self._close()
        if self._lost is not None:
            self._refuse_jobs(self._lost)
        if self._lost is not None and self._failed is None and self._at_loss is not None:
            self._say_last(self._at_loss)

    def _say_last(self, at_loss: Callable[[W], None]) -> None:
        with suppress(Exception):
            self._wire.connect()
            at_loss(self._wire)
        self._close()

    def _serve(self) -> None:
        self._wire.connect()
        self._poll()
        self._started.set()
        due = time.monotonic() + self._period
        while not self._ending.is_set() and self._lost is None:
            try:
                job = self._jobs.get(timeout=max(due - time.monotonic(), 0.0))
            except Empty:
                self._poll()
                due = max(due + self._period, time.monotonic())
                continue
            if job is not None:
                self._answer(*job)

    def _close(self) -> None:
        with suppress(Exception):
            self._wire.close()

    def _poll(self) -> Sample[S]:
        asked = self._now()
        value = self._wire.read()
        sample = Sample(value, asked, self._sample.number + 1 if self._sample else 0)
        if self._after_poll is not None:
            self._after_poll(self._wire, sample)
        self._sample, self._heard = sample, time.monotonic()
        return sample

    def _answer(self, future: Future[Any], job: Callable[[W], Any]) -> None:
        if not future.set_running_or_notify_cancel():
            return
        try:
            result = job(self._wire)
        except DeviceFault as fault:
            _refuse(future, fault)
        except Exception as error:
            _refuse(future, _as_wire_error(error))
            raise
        else:
            with suppress(InvalidStateError):
                future.set_result(result)

    def _lose(self, error: Exception) -> None:
        """Write down a loss."""
        failed = _as_wire_error(error)
        reason = str(failed)
        if not self._started.is_set():
            self._failed = error if isinstance(error, ImportError) else failed
            self._started.set()
        self._latch(reason)

    def _refuse_jobs(self, reason: str) -> None:
        with suppress(Empty):
            while True:
                job = self._jobs.get_nowait()
                if job is not None and job[0].set_running_or_notify_cancel():
                    _refuse(job[0], WireError(reason))


def _refuse(future: Future[Any], error: Exception) -> None:
    with suppress(InvalidStateError):
        future.set_exception(error)


def _as_wire_error(error: Exception) -> WireError:
    if isinstance(error, WireError):
        return error
    text = writable(error) or "no reason given"
    return WireError(text if isinstance(error, OSError) else f"{type(error).__name__}: {text}")
