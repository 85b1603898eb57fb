"""A simulated force sensor."""

from __future__ import annotations

from typing import Literal

from stretch_bt.frames import Wrench
from stretch_bt.hardware.driver import Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.simulated.samples import sample_wrench
from stretch_bt.hardware.zeroed import ZeroedForceSensor

__all__ = ["SimulatedForceSensor"]


class _Options(Options):
    type: Literal["ForceSensor"]
    use: Literal["simulated"]


class SimulatedForceSensor(ZeroedForceSensor):
    """Measures the contact force with the scene's noise."""

    Options = _Options
    simulated = any_clock = True

    def raw(self) -> Reading[Wrench]:
        """Return the latest wrench of the twin."""
        return sample_wrench(self.cell.twin, "ForceSensor", self.name)
