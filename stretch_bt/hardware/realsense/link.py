"""The process of a camera as a wire: begun, listened to, ended."""

from __future__ import annotations

import mmap
import os
import select
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from stretch_bt.errors import MissingExtra
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.attendant import WireError
from stretch_bt.hardware.channel import ChannelClosed, Message
from stretch_bt.hardware.child import Child
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.realsense.judge import Counters
from stretch_bt.hardware.realsense.settings import Settings

__all__ = ["CameraLink", "CameraState"]

_MODULE = "stretch_bt.hardware.realsense.process"
#: the largest image that it takes, bytes
_LARGEST = 2 * 4096 * 4096
_TURN = 0.05
#: how long the process may take to connect and to bring a first frame; be silent itself; be without a frame before it is begun anew; end, s
_OPENING, _MUTE, _ANEW, _ENDING = 12.0, 1.5, 3.0, 3.0
#: silent for longer, s, it is not waited for at the end
_LIVELY = 0.3


@dataclass(frozen=True)
class CameraState:
    """The latest good frame, and how the camera stands: `silent` is since when none came, s."""

    latest: Reading[DepthFrame]
    silent: float
    bad: str | None
    ended: bool
    counters: Counters


class CameraLink:
    """Keeps one process that keeps one camera; used by one thread, but for `leave` and `event`.

    Parameters
    ----------
    name
        The device, for messages.
    settings
        What the process goes by.
    latency
        From exposure to arrival at least, s.
    plane_distance
        Camera to the flat membrane, m, where the camera has its own.
    now
        The clock of the run, s.
    """

    def __init__(
        self,
        name: str,
        settings: Settings,
        *,
        latency: float,
        plane_distance: float | None,
        now: Callable[[], float],
    ) -> None:
        self.name = name
        self._settings, self._latency, self._distance, self._now = settings, latency, plane_distance, now
        self._memory: mmap.mmap | None = None
        self._child: Child | None = None
        self._leaving = False
        self._known: tuple[Intrinsics, float, str] | None = None
        self._latest: Reading[DepthFrame] | None = None
        self._state: CameraState | None = None
        self._events: deque[str] = deque()
        self._number = 0
        self._heard = 0.0

    @property
    def pid(self) -> int | None:
        """Number of the process, while there is one."""
        child = self._child
        return None if child is None else child.pid

    @property
    def intrinsics(self) -> Intrinsics | None:
        """What the camera told of its lens, once it was connected."""
        return None if self._known is None else self._known[0]

    def leave(self) -> None:
        """Give up connecting; from any thread."""
        self._leaving = True

    def event(self) -> str | None:
        """Return the first thing that happened since this was asked last and that somebody has to know; from any thread."""
        events = [self._events.popleft() for _ in range(len(self._events))]
        return events[0] if events else None

    def connect(self) -> None:
        """Begin the process, and wait for a first good frame."""
        descriptor = os.memfd_create("frames")
        try:
            os.ftruncate(descriptor, _LARGEST)
            self._memory = mmap.mmap(descriptor, _LARGEST)
            self._child = Child(_MODULE, [self._settings.to_message()], [descriptor])
        finally:
            os.close(descriptor)
        self._latest = self._state = None
        self._heard = time.monotonic()
        end = self._heard + _OPENING
        while self._latest is None:
            self._listen(end)
            if time.monotonic() > end or self._leaving:
                raise WireError(self._why_not())

    def read(self) -> CameraState:
        """Return how the camera stands, after a short wait for news of it; raises WireError."""
        self._listen(self._heard + _MUTE)
        assert self._state is not None
        if not self._state.ended and self._state.silent > _ANEW + self._settings.lost_after:
            raise WireError(f"no good frame came for {self._state.silent:.2g} s ({self._state.bad or 'nothing came'})")
        return self._state

    def close(self) -> None:
        """End the process, which has a moment to end a recording of what came, unless it hangs; may be called more than once."""
        child, self._child = self._child, None
        if child is not None:
            lively = time.monotonic() - self._heard < _LIVELY or select.select([child.channel], [], [], 0.0)[0]
            child.end(_ENDING if self._latest is not None and lively else 0.0)
        memory, self._memory = self._memory, None
        if memory is not None:
            memory.close()

    def _listen(self, due: float) -> None:
        """Take what came; raises WireError when the process ended, or was silent until a time."""
        child = self._child
        assert child is not None
        try:
            if select.select([child.channel], [], [], _TURN)[0]:
                for message in child.channel.drain():
                    self._take(message)
                self._heard = time.monotonic()
            elif time.monotonic() > due:
                child.kill()
                raise WireError(f"its process gave no sign of life for {time.monotonic() - self._heard:.2g} s")
        except ChannelClosed as error:
            raise WireError(child.why(error)) from error

    def _take(self, message: Message) -> None:
        match message.get("say"):
            case "ready":
                self._keep(message)
            case "state":
                if message["shot"] is not None:
                    self._latest = self._reading(message["shot"])
                if message["event"] is not None:
                    self._events.append(message["event"])
                if self._latest is not None:
                    named = {k: message[k] for k in ("silent", "bad", "ended")}
                    self._state = CameraState(self._latest, counters=Counters(**message["counters"]), **named)
            case "lost":
                if message["missing"]:
                    raise MissingExtra(f"{self.name} needs pyrealsense2: {message['reason']}")
                raise WireError(message["reason"])

    def _keep(self, message: Mapping[str, Any]) -> None:
        """Keep what the camera says of itself, which must stay as it is."""
        fx, fy, cx, cy, width, height, distortion = message["lens"]
        lens = Intrinsics(fx, fy, cx, cy, width, height, tuple(distortion))
        told = lens, message["unit"], message["device"].get("serial", "")
        if self._known is not None and self._known != told:
            raise WireError("another camera answers than the one that was opened; close and open it for that")
        self._known = told

    def _reading(self, shot: Mapping[str, Any]) -> Reading[DepthFrame]:
        """Copy a frame out of the shared memory, and ask for the next one."""
        assert self._known is not None
        assert self._memory is not None
        assert self._child is not None
        lens, unit, _ = self._known
        raw = np.frombuffer(self._memory, np.uint16, lens.height * lens.width).reshape(lens.height, lens.width).copy()
        raw.setflags(write=False)
        with suppress(ChannelClosed):  # what it said before it ended is read first
            self._child.channel.send({"do": "next"})
        self._number += 1
        frame = DepthFrame(raw, unit, lens, shot["time"], self._number, plane_distance=self._distance)
        age = time.monotonic() - shot["exposed"] + self._latency
        return Reading(frame, shot["time"], self._now() - age, self._number)

    def _why_not(self) -> str:
        state = self._state
        return f"no good frame came within {_OPENING:g} s" + (f" ({state.bad})" if state and state.bad else "")
