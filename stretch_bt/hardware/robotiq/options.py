"""Options that the gripper has in a cell file, whatever it is reached by."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from stretch_bt.hardware.driver import Mistake, Options
from stretch_bt.hardware.robotiq.calibration import GripperCalibration
from stretch_bt.units import KINDS, Length, Speed, Time
from stretch_bt.within import Within

__all__ = ["RobotiqOptions"]

_FingerSpeed = Annotated[Speed, Within(0.001, 1.0, "Speed")]
_SPEEDS = {"2f85": (0.020, 0.150), "2f140": (0.030, 0.250)}


class RobotiqOptions(Options):
    """Model, calibration, force and pace."""

    model: Literal["2f85", "2f140"]
    calibration: GripperCalibration
    force: Annotated[int, Within(0, 255)] = Field(
        default=255, description="force of the fingers, the gripper's own count"
    )
    slowest: _FingerSpeed | None = Field(
        default=None, description="speed at speed count 0; by default the speed in the data sheet"
    )
    fastest: _FingerSpeed | None = Field(
        default=None, description="speed at speed count 255; by default the speed in the data sheet"
    )
    tolerance: Annotated[Length, Within(0.0001, 0.01, "Length")] = Field(
        default=0.001, description="largest distance of a motion's end from its target"
    )
    rate: Annotated[float, KINDS["Frequency"], Within(2.0, 200.0, "Frequency")] = Field(
        default=30.0, description="rate of asking for the status"
    )
    timeout: Annotated[Time, Within(0.02, 0.5, "Time")] = Field(default=0.15, description="timeout of one exchange")

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield when the speeds do not rise."""
        slow, fast = self.speeds
        if slow >= fast:
            key = "slowest" if self.slowest is not None else "fastest"
            told = f"the slowest speed, {1e3 * slow:g} mm/s, is not below the fastest, {1e3 * fast:g} mm/s"
            yield key, told, "write speeds that rise from count 0 to 255"

    def openings(self) -> tuple[float, float]:
        """Return the least and the greatest calibrated opening, m."""
        return self.calibration.span

    @property
    def speeds(self) -> tuple[float, float]:
        """Speeds at the counts 0 and 255, m/s."""
        slow, fast = _SPEEDS[self.model]
        return self.slowest or slow, self.fastest or fast

    def speed_count(self, speed: float) -> int:
        """Return the count that is not faster than a speed, m/s; the gripper's least where that is faster."""
        slow, fast = self.speeds
        return min(max(int(255 * (speed - slow) / (fast - slow) + 1e-9), 0), 255)
