"""The thread that receives a stream of records and keeps the newest."""

from __future__ import annotations

import math
import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.ati.delay import Delay
from stretch_bt.hardware.ati.pace import Pace
from stretch_bt.hardware.ati.rdt import Ask, Record, request, status_text
from stretch_bt.hardware.ati.screen import Screen
from stretch_bt.hardware.ati.stream import RecordCounters, Stream

__all__ = ["Measurement", "Receiver"]

_BUFFER = 1 << 18
_LONGEST = 2048
#: a clock that nobody sets or slews
_STEADY = getattr(time, "CLOCK_MONOTONIC_RAW", time.CLOCK_MONOTONIC)
_KEPT = 40_000


@dataclass(frozen=True, slots=True)
class Measurement:
    """A record, the host's time at which it was measured, s, and how many came before it."""

    record: Record
    time: float
    number: int


class Receiver:
    """Asks a sensor for its stream, again whenever it falls silent, and stops the stream at the end.

    Parameters
    ----------
    address
        Host and port of the sensor.
    silence
        Time without a record, s, after which the stream is asked for again.
    lost_after
        Time without a new measurement, s, after which it counts as an event that the sensor was gone.
    keep
        How long measurements are kept for averages, s.
    now
        The clock of the run, s.
    screen
        Tells which records can be believed.
    """

    def __init__(
        self,
        address: tuple[str, int],
        *,
        silence: float,
        lost_after: float,
        keep: float,
        now: Callable[[], float],
        screen: Screen,
    ) -> None:
        self._address, self._silence, self._lost_after = address, silence, lost_after
        self._keep, self._now = keep, now
        self._stream, self._screen = Stream(), screen
        self._delay, self._pace = Delay(), Pace()
        self._kept: deque[Measurement] = deque(maxlen=_KEPT)
        self._number = 0
        self._lock = threading.Lock()
        self._first = threading.Event()
        self._ending = threading.Event()
        self._event: str | None = None
        #: host's monotonic times of the last record, of the last new measurement and of the last packet that is no record, s
        self.heard = self.new = self.malformed = 0.0
        #: what is wrong with that packet
        self.wrong = ""
        self.broken: str | None = None
        self._socket: socket.socket | None = None
        self._thread = threading.Thread(target=self._run, name="RDT receiver", daemon=True)

    @property
    def counters(self) -> RecordCounters:
        """What came, and what did not."""
        return self._stream.counters

    def start(self, within: float) -> bool:
        """Ask for the stream, and return whether a measurement came within a time, s; raises OSError."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self._socket.connect(self._address)
        self._thread.start()
        return self._first.wait(within)

    def end(self) -> None:
        """Stop the stream and the thread; a sensor that is not stopped goes on sending."""
        self._ending.set()
        if self._thread.ident is not None:
            self._thread.join(2.0)
        if self._socket is not None:
            with suppress(OSError):
                self._socket.send(request(Ask.STOP))
            self._socket.close()

    def event(self) -> str | None:
        """Return, once, the first thing that went wrong since this was asked last."""
        with self._lock:
            event, self._event = self._event, None
        return event

    def newest(self) -> Measurement | None:
        """Return the newest measurement."""
        with self._lock:
            return self._kept[-1] if self._kept else None

    def recent(self, since: float) -> list[Measurement]:
        """Return the measurements from a time on, s."""
        with self._lock:
            return [m for m in self._kept if m.time >= since]

    def _run(self) -> None:
        assert self._socket is not None
        asked = -float("inf")
        while not self._ending.is_set():
            try:
                if select.select([self._socket], [], [], 0.0 if asked < 0 else min(self._silence, 0.05))[0]:
                    self._drain()
                if time.monotonic() - max(self.heard, asked) > self._silence:
                    asked = time.monotonic()
                    self._socket.send(request(Ask.STREAM))
            except OSError as error:  # a host that refuses the port says so on the next call
                self.broken = str(error)
                self._ending.wait(min(self._silence, 0.05))

    def _drain(self) -> None:
        """Take all that has come; only a new measurement is kept."""
        assert self._socket is not None
        while select.select([self._socket], [], [], 0.0)[0] and not self._ending.is_set():
            data = self._socket.recv(_LONGEST)
            try:
                record = Record.decode(data)
            except InvalidInput as error:
                self._stream.counters.malformed += 1
                self.malformed, self.wrong = time.monotonic(), str(error)
                continue
            self.heard, self.broken = time.monotonic(), None
            if self._stream.take(record):
                self._keep_it(record)
            if self._stream.began_anew:
                self._note("the numbers of its records went back: the sensor was restarted")
                self._stream.go_on()
                self._delay, self._pace = Delay(), Pace()

    def _keep_it(self, record: Record) -> None:
        now = time.monotonic()
        if self._pace.broke(record):  # times of arrival before it say nothing of those after it
            self._delay = Delay()
        late = self._delay.take(record.cycle, time.clock_gettime(_STEADY))
        if not record.status and not self._believed(record, now):
            return
        gone = now - self.new
        if self._kept and gone > self._lost_after:
            self._note(f"it was silent for {gone:.2g} s, and sends again")
        if record.status:
            self._note(f"the sensor reported status {record.status:08X}: {status_text(record.status)}")
        with self._lock:
            taken = self._now() - late
            if self._kept:  # how late records are is an estimate, and may rise by more than passed between two of them
                taken = max(taken, math.nextafter(self._kept[-1].time, math.inf))
            self._kept.append(Measurement(record, taken, self._number))
            self._number += 1
            while self._kept[0].time < self._kept[-1].time - self._keep - 1e-9:
                self._kept.popleft()
        self.new = now
        self._first.set()

    def _believed(self, record: Record, now: float) -> bool:
        believed = self._screen.take(record, now)
        self._stream.counters.wild += not believed
        self._note(self._screen.event())
        return believed

    def _note(self, event: str | None) -> None:
        with self._lock:
            self._event = self._event or event
