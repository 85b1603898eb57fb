"""The process that has librealsense: a crash or a hang of it ends this process, and nothing else.

It looks at every frame, keeps the newest good one, and hands it over in shared memory when it is asked for the next. It ends when the run
is gone; one that hangs is ended by its own alarm.
"""

from __future__ import annotations

import mmap
import os
import signal
import socket
import sys
import time
from contextlib import suppress
from typing import Any, NoReturn

import numpy as np

from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.priority import raise_priority
from stretch_bt.hardware.realsense.judge import Judge, Shot
from stretch_bt.hardware.realsense.settings import Settings
from stretch_bt.hardware.realsense.sources import open_source

__all__ = ["main"]

#: how long one turn, connecting, and ending may take before the process is ended, s
_STUCK, _CONNECTING, _ENDING = 3.0, 10.0, 3.0
_TURN = 0.02
#: a turn that is later than this, s, was not given its time by the machine
_LATE = 0.1


class _Keeper:
    """Keeps one camera; `memory` is where frames are handed over."""

    def __init__(self, channel: Channel, memory: mmap.mmap, settings: Settings) -> None:
        self._channel, self._memory = channel, memory
        self._source = open_source(settings)
        self._source.start()
        self._judge = Judge(settings.lost_after, settings.noisy, time.monotonic())
        self._newest: Shot | None = None
        self._wanted = True
        self._ended = False

    def run(self) -> None:
        """Go on until the other side is gone."""
        lens = self._source.intrinsics
        self._channel.send(
            {
                "say": "ready",
                "unit": self._source.unit,
                "lens": [lens.fx, lens.fy, lens.cx, lens.cy, lens.width, lens.height, lens.distortion],
                "device": self._source.described(),
            }
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

    def end(self) -> None:
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
            self._judge.bad = "what it sends is broken"
        self._ended = self._source.ended and not came

    def _listen(self) -> None:
        for message in self._channel.drain():
            match message.get("do"):
                case "next":
                    self._wanted = True
                case "end":
                    raise ChannelClosed("told to end")

    def _tell(self) -> None:
        shot: dict[str, Any] | None = None
        if self._wanted and self._newest is not None:
            newest, self._newest, self._wanted = self._newest, None, False
            flat = np.frombuffer(self._memory, np.uint16, newest.image.size)
            flat[:] = newest.image.ravel()
            shot = {"number": newest.number, "time": newest.time, "exposed": newest.exposed}
        event, self._judge.event = self._judge.event, None
        self._channel.send(
            {
                "say": "state",
                "shot": shot,
                "silent": self._judge.silent(time.monotonic()),
                "bad": self._judge.bad,
                "event": event,
                "ended": self._ended,
                "counters": self._judge.counters.to_message(),
            }
        )


def main(descriptor: int, memory: int) -> NoReturn:
    """Keep a camera for the process at the other end of a socket; ends without the library's destructors, which may hang."""
    channel = Channel(socket.socket(fileno=descriptor))
    raise_priority()
    keeper = None
    try:
        signal.setitimer(signal.ITIMER_REAL, _CONNECTING)
        keeper = _Keeper(channel, mmap.mmap(memory, 0), Settings.from_message(channel.first()[0]))
        keeper.run()
    except ChannelClosed:
        pass  # told to end, or nobody is there any more
    except BaseException as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        with suppress(ChannelClosed):
            channel.send({"say": "lost", "reason": reason, "missing": isinstance(error, ImportError)})
    finally:
        if keeper is not None:
            with suppress(Exception):
                keeper.end()
        sys.stderr.flush()
        os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
