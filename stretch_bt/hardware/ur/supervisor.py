"""The process that has the clients of ur_rtde, as the driver sees it: begun, listened to, ended and begun again."""

from __future__ import annotations

import select
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress

from stretch_bt.errors import DeviceLost, MissingExtra
from stretch_bt.hardware.attendant import Sample
from stretch_bt.hardware.channel import Channel, ChannelClosed, Message
from stretch_bt.hardware.child import Child
from stretch_bt.hardware.latched import Latched
from stretch_bt.hardware.ur.settings import ArmState, Settings

__all__ = ["Supervisor"]

_BEAT = 0.05
#: how long the process may be silent, s: more than the controller may be while it works; while it connects; while it makes ready to move
_MORE, _CONNECTING, _ENGAGING = 0.2, 5.0, 11.0
_BACKOFF = (0.1, 0.2, 0.5, 1.0, 2.0)
_MODULE = "stretch_bt.hardware.ur.process"


class Supervisor(Latched):
    """Keeps one process that keeps one arm.

    After a loss it begins another, which reads again but is not made ready to move until `acknowledge`.

    Parameters
    ----------
    name
        The device, for messages.
    settings
        What the process goes by.
    now
        The clock of the run, s.
    contact_height
        Returns the world height of first contact, m, once it is known.
    """

    def __init__(
        self, name: str, settings: Settings, now: Callable[[], float], contact_height: Callable[[], float | None]
    ) -> None:
        super().__init__(name)
        self._settings, self._now, self._contact_height = settings, now, contact_height
        self._watched = 0.0
        self._ending = threading.Event()
        self._started = threading.Event()
        self._lock = threading.Lock()
        self._channel: Channel | None = None
        self._child: Child | None = None
        self._sample: Sample[ArmState] | None = None
        self._zero: tuple[float, ...] | None = None
        self._number = self._read = 0
        self._waiting: dict[int, Future[Message]] = {}
        self._connecting, self._engaging = True, False
        self._heard = 0.0
        self._failed: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=f"supervisor of {name}", daemon=True)

    @property
    def pid(self) -> int | None:
        """Number of the process, while there is one."""
        child = self._child
        return None if child is None else child.pid

    def start(self) -> None:
        """Begin the process and wait for a first reading; raises DeviceLost when none comes, and then nothing is left."""
        self._thread.start()
        try:
            if not self._started.wait(_CONNECTING + 1.0):
                self._failed = ChannelClosed("it was not connected in time")
        except BaseException:  # such as Ctrl-C: nobody will end it later
            self.end()
            raise
        if self._failed is not None:
            self.end()
            if isinstance(self._failed, MissingExtra):
                raise self._failed
            raise DeviceLost(
                self.name, f"cannot be reached at {self._settings.host} ({self._failed})"
            ) from self._failed

    def end(self) -> None:
        """End the process and the thread."""
        self._ending.set()
        with suppress(ChannelClosed):
            self.send({"do": "end"})
        if self._thread.ident is not None:
            self._thread.join(5.0)

    def latest(self) -> Sample[ArmState]:
        """Return the latest sample.

        Raises
        ------
        DeviceLost
            There is no process or no connection, or there was none since this was asked last.
        """
        self._tell_loss()
        assert self._sample is not None
        return self._sample

    def watch(self) -> None:
        """Take note that whoever leads the arm looks at its motion now."""
        self._watched = time.monotonic()

    def keep_zero(self, wrench: tuple[float, ...]) -> None:
        """Take a wrench off all that follow, also of a process that is begun later."""
        self._zero = wrench
        self.send({"do": "zero", "wrench": wrench})

    def send(self, message: Message) -> None:
        """Send a message; raises ChannelClosed."""
        with self._lock:
            if self._channel is None:
                raise ChannelClosed(self._down or "there is no process")
            self._channel.send(message)

    def number(self) -> int:
        """Return a number that no other message has."""
        with self._lock:
            self._number += 1
            return self._number

    def engage(self, within: float, *, again: bool, unlock: bool) -> str | None:
        """Have the arm made ready to move, and return what keeps it from that; raises DeviceLost."""
        self._engaging = True  # the process is silent while it connects the client that controls
        try:
            reason: str | None = self.ask({"do": "engage", "again": again, "unlock": unlock}, within)["reason"]
        finally:
            self._heard, self._engaging = time.monotonic(), False
        return reason

    def ask(self, message: Message, within: float) -> Message:
        """Send a message and return the answer to it.

        Raises
        ------
        DeviceLost
            None came in time; the process is ended, and the controller's watchdog stops the arm.
        """
        number = self.number()
        future = self._waiting[number] = Future()
        try:
            self.send({**message, "number": number})
            return future.result(within)
        except TimeoutError:
            reason = f"its process did not answer within {within:.3g} s"
            self.kill()
            raise DeviceLost(self.name, f"the connection broke ({reason})") from None
        except ChannelClosed as error:
            raise DeviceLost(self.name, f"the connection broke ({error})") from error
        finally:
            self._waiting.pop(number, None)

    def kill(self) -> None:
        """End the process without its doing; the controller's watchdog stops the arm."""
        child = self._child
        if child is not None:
            child.kill()

    def _run(self) -> None:
        failures = 0
        while not self._ending.is_set():
            before = self._sample
            try:
                self._attend()
            except Exception as error:  # whatever breaks is a loss of the device, never of the thread
                self._lose(error)
            finally:
                self._reap()
            if not self._started.is_set():
                return
            failures = failures + 1 if self._sample is before else 0
            self._ending.wait(_BACKOFF[min(failures, len(_BACKOFF) - 1)])

    def _attend(self) -> None:
        channel = self._begin()
        self._heard, self._connecting = time.monotonic(), True
        beat, silence = 0.0, self._settings.lost_after + _MORE
        while not self._ending.is_set():
            now = time.monotonic()
            if now >= beat:
                beat = now + _BEAT
                with suppress(ChannelClosed):  # what it said before it ended is read first
                    self.send({"do": "beat", "contact_height": self._contact_height(), "watched": self._watched})
            if select.select([channel], [], [], _BEAT)[0]:
                for message in channel.drain():
                    self._take(message)
            silent = time.monotonic() - self._heard
            limit = _ENGAGING if self._engaging else _CONNECTING if self._connecting else silence
            if (
                silent > limit and not select.select([channel], [], [], 0.0)[0]
            ):  # else it was this thread that did not run
                raise ChannelClosed(f"its process gave no sign of life for {silent:.2g} s")

    def _begin(self) -> Channel:
        self._child = child = Child(_MODULE, [self._settings.to_message()])
        if self._zero is not None:
            child.channel.send({"do": "zero", "wrench": self._zero})
        with self._lock:
            self._channel = child.channel
        return child.channel

    def _take(self, message: Message) -> None:
        self._heard = time.monotonic()
        match message.get("say"):
            case "state":
                self._read += 1
                state = ArmState.from_message(message)
                self._sample = Sample(state, self._now(), self._read)
                self._down, self._connecting = None, False
                self._started.set()
            case "lost":
                if message["missing"]:
                    self._failed = MissingExtra(
                        f"{self.name} needs ur-rtde ({message['reason']}); install it with: pip install ur-rtde"
                    )
                raise ChannelClosed(message["reason"])
            case "engaged" | "guarded" | "stopped":
                future = self._waiting.get(message["number"])
                with suppress(InvalidStateError):
                    if future is not None:
                        future.set_result(message)

    def _lose(self, error: Exception) -> None:
        """Write down a loss, and refuse what waits for an answer."""
        if self._ending.is_set():
            return
        reason = self._why(error)
        if not self._started.is_set():
            self._failed = self._failed or ChannelClosed(reason)
            self._ending.set()
            self._started.set()
        self._latch(reason)
        for future in list(self._waiting.values()):
            with suppress(InvalidStateError):
                future.set_exception(ChannelClosed(reason))

    def _why(self, error: Exception) -> str:
        """Return why the process ended, from what it told or how it ended."""
        if isinstance(error, ChannelClosed) and self._child is not None:
            return self._child.why(error)
        return str(error) if isinstance(error, OSError) else f"{type(error).__name__}: {error}"

    def _reap(self) -> None:
        """Leave no process behind: it has a moment to brake when it was told to end."""
        with self._lock:
            self._channel = None
        child, self._child = self._child, None
        if child is not None:
            child.end(1.5 if self._ending.is_set() else 0.0)
