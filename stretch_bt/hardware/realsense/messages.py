"""What the driver of a camera and its process say to each other; SI."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.hardware.messages import Codec, Message
from stretch_bt.hardware.realsense.judge import FrameCounters

__all__ = ["CODEC", "CameraSettings", "CameraStatus", "Lens", "Next", "Taken"]


@dataclass(frozen=True, slots=True)
class CameraSettings(Message):
    """To the process, first: where the frames come from (one of `serial`, `file` and `host`), and what it goes by."""

    serial: str | None
    file: str | None
    host: str | None
    port: int
    width: int
    height: int
    rate: float
    lost_after: float
    noisy: bool
    record: str | None


@dataclass(frozen=True, slots=True)
class Lens(Message):
    """From the process, first: one count of depth, m, and the pinhole of the camera, pixels."""

    unit: float
    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    distortion: tuple[float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Taken:
    """A frame that is in the shared memory: the camera's time of it, and the monotonic time of its exposure, s."""

    time: float
    exposed: float


@dataclass(frozen=True, slots=True)
class CameraStatus(Message):
    """From the process: how the camera stands."""

    frame: Taken | None
    #: for how long no good frame came, s, and the mistake in the newest
    silent: float
    bad: str | None
    #: an event that somebody has to know
    event: str | None
    #: whether a recording is over
    ended: bool
    counters: FrameCounters


@dataclass(frozen=True, slots=True)
class Next(Message):
    """To the process: the frame was copied, the next one may be handed over."""


CODEC = Codec(CameraSettings, Lens, CameraStatus, Next)
