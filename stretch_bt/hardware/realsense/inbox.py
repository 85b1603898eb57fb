"""What comes from the process of a camera: frames out of shared memory, and how the camera stands."""

from __future__ import annotations

import mmap
import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.messages import Message
from stretch_bt.hardware.realsense.judge import FrameCounters
from stretch_bt.hardware.realsense.messages import CameraStatus, Lens, Taken

__all__ = ["CameraState", "Inbox"]

#: the largest image that is handed over, bytes
_LARGEST = 2 * 4096 * 4096


@dataclass(frozen=True)
class CameraState:
    """The latest good frame, and how the camera stands: for how long none came, s, and what was wrong with the newest."""

    latest: Reading[DepthFrame]
    silent: float
    bad: str | None
    ended: bool
    counters: FrameCounters


class Inbox:
    """Takes the messages of a camera's process, in one thread; may be read from any.

    Parameters
    ----------
    latency
        Least time from exposure to arrival, s.
    plane_distance
        Distance from the camera to the flat membrane, m, where the camera has its own.
    now
        Returns the time of the run's clock and of the monotonic clock, s.
    """

    def __init__(self, *, latency: float, plane_distance: float | None, now: Callable[[], tuple[float, float]]) -> None:
        self._latency, self._distance, self._now = latency, plane_distance, now
        self.descriptor = os.memfd_create("frames")
        os.ftruncate(self.descriptor, _LARGEST)
        self._memory = mmap.mmap(self.descriptor, _LARGEST)
        self._lens: tuple[Intrinsics, float] | None = None
        self._latest: Reading[DepthFrame] | None = None
        self._number = 0
        self.state: CameraState | None = None
        self._event: str | None = None

    @property
    def intrinsics(self) -> Intrinsics | None:
        """What the camera says of its lens, once it was connected."""
        return None if self._lens is None else self._lens[0]

    def event(self) -> str | None:
        """Return, once, the first thing that happened since this was asked last and that somebody has to know."""
        event, self._event = self._event, None
        return event

    def take(self, message: Message) -> bool:
        """Take a message, and return whether a frame was copied."""
        match message:
            case Lens():
                m = message
                self._lens = Intrinsics(m.fx, m.fy, m.cx, m.cy, m.width, m.height, m.distortion), m.unit
            case CameraStatus():
                if message.frame is not None:
                    self._latest = self._reading(message.frame)
                self._event = self._event or message.event
                if self._latest is not None:
                    self.state = CameraState(self._latest, message.silent, message.bad, message.ended, message.counters)
                return message.frame is not None
        return False

    def close(self) -> None:
        """Give the memory back; after this no message is taken."""
        self._memory.close()
        os.close(self.descriptor)

    def _reading(self, taken: Taken) -> Reading[DepthFrame]:
        """Copy a frame out of the shared memory."""
        assert self._lens is not None
        lens, unit = self._lens
        raw = np.frombuffer(self._memory, np.uint16, lens.height * lens.width).reshape(lens.height, lens.width).copy()
        raw.setflags(write=False)
        self._number += 1
        frame = DepthFrame(raw, unit, lens, taken.time, self._number, plane_distance=self._distance)
        now, monotonic = self._now()
        age = monotonic - taken.exposed + self._latency
        return Reading(frame, taken.time, now - age, self._number)
