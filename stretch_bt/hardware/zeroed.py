"""The common part of force sensors whose zero is kept here, not in the sensor."""

from __future__ import annotations

from abc import abstractmethod

from stretch_bt.frames import Wrench
from stretch_bt.hardware.driver import ForceSensorDriver
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.wrenches import minus

__all__ = ["ZeroedForceSensor"]


class ZeroedForceSensor(ForceSensorDriver):
    """Subtracts the wrench that was taken as zero from each wrench that `raw` returns."""

    _zero = Wrench((0.0, 0.0, 0.0))

    @abstractmethod
    def raw(self) -> Reading[Wrench]:
        """Return the latest wrench as the sensor has it."""

    def wrench(self) -> Reading[Wrench]:
        """Return the wrench since the last `zero`; raises what `raw` raises."""
        return minus(self.raw(), self._zero)

    def zero(self) -> None:
        """Take the present wrench as zero."""
        self._zero = self.raw().value
