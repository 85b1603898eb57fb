"""What a driver's reading must be, for a run as for whoever looks at a device."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.errors import shown
from stretch_bt.frames import DepthFrame, Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.plain_numbers import is_number

__all__ = ["check_reading"]

_VALUES = {"pose": Pose, "wrench": Wrench, "frame": DepthFrame}
#: how far ahead of the host's clock a reading may be, s
_AHEAD = 0.25


def check_reading(name: str, reading: Any, now: float) -> None:
    """Refuse a value that is no reading of this name, or of no valid time: neither NaN nor a future time is ever found too old.

    `now` is the host's time, s. Raises TypeError or ValueError, which are defects of the driver.
    """
    if not isinstance(reading, Reading):
        raise TypeError(f"a driver returns a Reading, not a {type(reading).__name__}")
    wanted, value = _VALUES.get(name), reading.value
    if wanted is not None and not isinstance(value, wanted):
        raise TypeError(f"{name}() returns a Reading of a {wanted.__name__}, not of {shown(value)}")
    if wanted is None and not is_number(value):
        raise ValueError(f"a driver's reading is {shown(value)}; where there is no {name} it raises NoAnswer")
    if not math.isfinite(reading.host_time):
        raise ValueError(f"a driver's reading has the time {reading.host_time}")
    if reading.host_time > now + _AHEAD:
        ahead = f"{reading.host_time - now:.3g} s ahead of the clock of the run"
        raise ValueError(f"the time of a driver's {name} is {ahead}; its host_time is what self.now() gives")
