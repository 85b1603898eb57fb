"""A simulated force sensor."""

from __future__ import annotations

from typing import Literal

from stretch_bt.frames import Wrench
from stretch_bt.hardware.driver import ForceSensorDriver, Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.simulated.samples import sample_wrench
from stretch_bt.hardware.wrenches import minus

__all__ = ["SimulatedForceSensor"]


class _Options(Options):
    type: Literal["ForceSensor"]
    use: Literal["simulated"]


class SimulatedForceSensor(ForceSensorDriver):
    """Measures the contact force with the scene's noise."""

    Options = _Options
    simulated = any_clock = True
    _zero = Wrench((0.0, 0.0, 0.0))

    def wrench(self) -> Reading[Wrench]:
        """Return the wrench since the last `zero`."""
        return minus(self._raw(), self._zero)

    def zero(self) -> None:
        """Take the present wrench as zero."""
        self._zero = self._raw().value

    def _raw(self) -> Reading[Wrench]:
        return sample_wrench(self.cell.twin, "ForceSensor", self.name)
