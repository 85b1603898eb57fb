"""ATI force and torque sensors that stream by RDT."""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceFault, DeviceLost, NotReady, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.ati.options import AtiOptions
from stretch_bt.hardware.ati.rdt import status_text
from stretch_bt.hardware.ati.receiver import Measurement, Receiver
from stretch_bt.hardware.ati.screen import Screen
from stretch_bt.hardware.ati.stream import RecordCounters
from stretch_bt.hardware.driver import ForceSensorDriver
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.wrenches import minus

__all__ = ["AtiForceSensor"]

_NONE = Wrench((0.0, 0.0, 0.0))
_OPENING = 2.0
_NOBODY = "check its supply, the cable, and that RDT is switched on"


class AtiForceSensor(ForceSensorDriver):
    """An ATI sensor with a network interface, such as the Axia80, by its UDP stream RDT; `zero` is kept here, not in the sensor."""

    streams = True
    Options = AtiOptions
    options: AtiOptions
    _receiver: Receiver | None = None
    _zero = _NONE

    def claimed(self) -> str:
        """Return which sensor it is: its stream goes to the client that asked last."""
        return f"the force sensor at {self.options.host} port {self.options.port}"

    def open(self) -> None:
        """Ask for the stream; raises DeviceLost when no measurement comes."""
        o = self.options
        c = o.calibration
        receiver = Receiver(
            (o.host, o.port),
            silence=o.silence,
            lost_after=o.lost_after,
            keep=o.zero_over,
            now=self.cell.now,
            screen=Screen(c.counts_per_newton, c.counts_per_newton_metre, o.noisy),
        )
        try:
            heard = receiver.start(_OPENING)
        except OSError as error:
            receiver.end()
            raise DeviceLost(self.name, f"cannot be asked at {o.host} port {o.port} ({error})") from error
        except BaseException:  # a signal; what nobody closes later would go on asking for the stream
            receiver.end()
            raise
        if not heard:
            receiver.end()
            event = receiver.event()
            why = f": {event}; look at its manual" if event else self._why(receiver, _OPENING, _NOBODY)
            what = f"no measurement from {o.host} port {o.port} within {_OPENING:.0f} s"
            raise DeviceLost(self.name, f"{what}{why}")
        self._receiver = receiver

    def close(self) -> None:
        """Stop the stream."""
        receiver, self._receiver = self._receiver, None
        if receiver is not None:
            receiver.end()

    def wrench(self) -> Reading[Wrench]:
        """Return the newest wrench since the last `zero`, in world axes.

        Raises
        ------
        DeviceLost
            No new measurement came for too long.
        DeviceFault
            The sensor reports an error; once for an error that is over, for a silence that is over, and for a restart.
        """
        newest = self._checked()
        wrench = self._in_world(self._mean([newest]))
        reading = Reading(wrench, newest.time, newest.time, newest.number)
        return minus(reading, self._zero)

    def zero(self) -> None:
        """Take the mean of the latest measurements as zero; raises StaleReading when they are old."""
        newest = self._checked()
        now = self.cell.now()
        if now - newest.time > self.options.lost_after:
            raise StaleReading(self.name, f"the latest measurement is {now - newest.time:.3g} s old")
        assert self._receiver is not None
        recent = self._receiver.recent(newest.time - self.options.zero_over)
        self._zero = self._in_world(self._mean(m for m in recent if not m.record.status))

    def counters(self) -> RecordCounters:
        """Return how many records came, were lost, late, repeated or stale."""
        return self._opened().counters

    def _opened(self) -> Receiver:
        if self._receiver is None:
            raise NotReady(self.name, "the device is closed")
        return self._receiver

    def _checked(self) -> Measurement:
        """Return the newest measurement of a sensor that is well."""
        receiver = self._opened()
        newest, event = receiver.newest(), receiver.event()
        assert newest is not None
        if event is not None:
            raise DeviceFault(
                self.name, f"{event}; take its load off, look at its manual, start a new run and zero it again"
            )
        silent = time.monotonic() - receiver.new
        if silent > self.options.lost_after:
            why = self._why(receiver, self.options.lost_after, "check its supply and the cable")
            raise DeviceLost(self.name, f"no measurement for {silent:.2g} s{why}, then start a new run")
        if newest.record.status:
            reason = f"the sensor reports status {newest.record.status:08X}: {status_text(newest.record.status)}"
            raise DeviceFault(self.name, f"{reason}; take its load off, look at its manual, then start a new run")
        return newest

    def _why(self, receiver: Receiver, within: float, nobody: str) -> str:
        """Return why no measurement came within the last time, s, and what to do; `nobody`: what to do where nothing came."""
        since = time.monotonic() - within
        if receiver.heard >= since:
            return ": it sends, but measures nothing new; switch it off and on"
        if receiver.malformed >= since:
            return (
                f": it sends, but no records ({receiver.wrong}); check that this is the sensor, and how its RDT is set"
            )
        why = f" ({receiver.broken})" if receiver.broken else ""
        return f": nothing came{why}; {nobody}"

    def _mean(self, measurements: Iterable[Measurement]) -> npt.NDArray[np.float64]:
        counts = np.array([m.record.counts for m in measurements], dtype=np.float64)
        mean: npt.NDArray[np.float64] = counts.mean(axis=0)
        return mean

    def _in_world(self, counts: npt.NDArray[np.float64]) -> Wrench:
        """Return six counts as what the world does to the hand, N and N m, in world axes."""
        o = self.options
        turn = Pose(rotation=(o.rotation.x, o.rotation.y, o.rotation.z)).matrix()
        sign = -1.0 if o.mount == "table" else 1.0  # a sensor under the object feels what the hand does to it
        force = sign * turn @ counts[:3] / o.calibration.counts_per_newton
        torque = sign * turn @ counts[3:] / o.calibration.counts_per_newton_metre
        (fx, fy, fz), (tx, ty, tz) = force.tolist(), torque.tolist()
        return Wrench((fx, fy, fz), (tx, ty, tz))
