"""The depth camera as nodes see it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.driver import DepthCameraDriver
from stretch_bt.hardware.interfaces import DepthCamera, Reading
from stretch_bt.hardware.monitored.base import Monitored

__all__ = ["MonitoredCamera"]


class MonitoredCamera(Monitored[DepthCameraDriver]):
    """A camera whose latest frame is given out only while it is fresh."""

    readings: ClassVar[Mapping[str, Any]] = DepthCamera.readings

    @property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the frames; raises NotReady before the camera is open where only the open camera knows them."""
        with self.faults():
            return self.driver.intrinsics

    @property
    def ended(self) -> bool:
        """Whether nothing new will ever come; an end is written down, because nodes decide by it."""
        with self.faults():
            ended = self.driver.ended
        if ended:
            now = self.watch.now()
            self.watch.journal.reading(self.name, "ended", Reading(True, now, now, 0))
        return ended

    def frame(self, max_age: float) -> Reading[DepthFrame]:
        """Return the latest frame, at most `max_age` s old; raises StaleReading."""
        return self.read("frame", self.driver.frame, max_age)
