"""The force sensor as nodes see it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from stretch_bt.frames import Wrench
from stretch_bt.hardware.driver import ForceSensorDriver
from stretch_bt.hardware.interfaces import ForceSensor, Reading
from stretch_bt.hardware.monitored.base import Monitored

__all__ = ["MonitoredForceSensor"]


class MonitoredForceSensor(Monitored[ForceSensorDriver]):
    """A force sensor whose latest wrench is given out only while it is fresh."""

    readings: ClassVar[Mapping[str, Any]] = ForceSensor.readings

    def wrench(self, max_age: float) -> Reading[Wrench]:
        """Return the wrench since the last `zero`, at most `max_age` s old."""
        return self.read("wrench", self.driver.wrench, max_age)

    def zero(self) -> None:
        """Take the present wrench as zero."""
        self.check_ready()
        self.command("zero", {}, "")
        with self.faults():
            self.driver.zero()
        now = self.watch.now()
        self.watch.journal.reading(self.name, "zeroed", Reading(True, now, now, 0))
