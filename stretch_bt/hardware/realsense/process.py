"""The process that has librealsense: a crash or a hang of it ends this process, and nothing else.

It looks at every frame, keeps the newest good one, and hands it over in shared memory when it is asked for the next. It ends when the run
is gone; one that hangs is ended by its own alarm.
"""

from __future__ import annotations

import mmap
import signal
import sys
import time
from dataclasses import replace
from functools import partial

import numpy as np

from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.keeper import keep
from stretch_bt.hardware.messages import End, Message
from stretch_bt.hardware.realsense.judge import Judge, TimedFrame
from stretch_bt.hardware.realsense.messages import CODEC, CameraSettings, CameraStatus, Lens, Next, Taken
from stretch_bt.hardware.realsense.sources import open_source

__all__ = ["CameraKeeper"]

#: how long one turn, connecting, a first good frame, and ending may take, s
_STUCK, _CONNECTING, _FIRST, _ENDING = 3.0, 10.0, 12.0, 3.0
_TURN = 0.02
#: a turn that is later than this, s, was not given its time by the machine
_LATE = 0.1


class CameraKeeper:
    """Keeps one camera.

    Parameters
    ----------
    memory
        Where frames are handed over.
    channel
        Channel to the driver.
    first
        Messages that came already, the first of them `CameraSettings`.
    """

    def __init__(self, memory: mmap.mmap, channel: Channel, first: list[Message]) -> None:
        settings = first[0]
        assert isinstance(settings, CameraSettings)
        self._channel, self._memory = channel, memory
        self._begun = time.monotonic()
        self._source = open_source(settings)
        self._source.start()
        self._judge = Judge(settings.lost_after, settings.noisy, time.monotonic())
        self._newest: TimedFrame | None = None
        self._wanted, self._first, self._ended = True, True, False

    def run(self) -> None:
        """Go on until the driver is gone."""
        lens = self._source.intrinsics
        self._channel.send(
            Lens(self._source.unit, lens.fx, lens.fy, lens.cx, lens.cy, lens.width, lens.height, lens.distortion)
        )
        woke = time.monotonic()
        while True:
            signal.setitimer(signal.ITIMER_REAL, _STUCK)
            woke, late = time.monotonic(), time.monotonic() - woke - _TURN
            if late > _LATE:  # this process did not run: nobody was silent towards it
                self._judge.excuse(late, woke)
            self._look()
            self._listen()
            self._tell()

    def end(self, *, lost: bool) -> None:
        """End the stream, so that a recording of it is whole."""
        signal.setitimer(signal.ITIMER_REAL, _ENDING)
        self._source.stop()

    def _look(self) -> None:
        broken, came = self._source.broken, False
        for shot in self._source.shots(_TURN):
            came = True
            self._newest = self._judge.take(shot) or self._newest
        self._judge.counters.broken = self._source.broken
        if self._source.broken > broken and not came:
            self._judge.bad = "its data are broken"
        self._ended = self._source.ended and not came
        if self._first and self._newest is None and time.monotonic() - self._begun > _FIRST:
            raise OSError(
                f"no good frame came within {_FIRST:g} s" + (f" ({self._judge.bad})" if self._judge.bad else "")
            )

    def _listen(self) -> None:
        for message in self._channel.drain():
            match message:
                case Next():
                    self._wanted = True
                case End():
                    raise ChannelClosed("asked to end")

    def _tell(self) -> None:
        taken = None
        if self._wanted and self._newest is not None:
            newest, self._newest, self._wanted, self._first = self._newest, None, False, False
            flat = np.frombuffer(self._memory, np.uint16, newest.image.size)
            flat[:] = newest.image.ravel()
            taken = Taken(newest.time, newest.exposed)
        event, self._judge.event = self._judge.event, None
        silent, counters = self._judge.silent(time.monotonic()), replace(self._judge.counters)
        self._channel.send(CameraStatus(taken, silent, self._judge.bad, event, self._ended, counters))


if __name__ == "__main__":
    keep(
        int(sys.argv[1]),
        CODEC,
        partial(CameraKeeper, mmap.mmap(int(sys.argv[2]), 0)),
        opening=_CONNECTING,
        package="pyrealsense2: {}",
    )
