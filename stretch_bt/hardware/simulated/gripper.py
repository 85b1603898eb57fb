"""A simulated gripper."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from stretch_bt.hardware.driver import GripperDriver, Options, Poll
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.motion.profile import Profile
from stretch_bt.hardware.simulated.samples import sample
from stretch_bt.units import KINDS, Length
from stretch_bt.within import Within

__all__ = ["SimulatedGripper"]

_ROUNDING = 1e-9


class _Options(Options):
    type: Literal["Gripper"]
    use: Literal["simulated"]
    acceleration: Annotated[float, KINDS["Acceleration"], Within(0.01, 20.0, "Acceleration")] = 1.0
    max_opening: Annotated[Length, Within(0.01, 0.5, "Length")] = Field(
        default=0.14, description="largest opening of the fingers"
    )

    def openings(self) -> tuple[float, float]:
        """Return where the fingers end, m."""
        return 0.0, self.max_opening


class SimulatedGripper(GripperDriver):
    """Moves its fingers on a trapezoid of speed, up to their ends."""

    Options = _Options
    simulated = any_clock = True

    def move(self, opening: float, speed: float) -> Poll:
        """Move the fingers to an opening, m."""
        twin = self.cell.twin
        start = twin.fingers.at(self.cell.now())
        reached = min(max(opening, 0.0), self.options.max_opening)
        sign = math.copysign(1.0, reached - start)
        length = abs(reached - start)
        profile = Profile.trapezoid(length, speed, self.options.acceleration)
        end = twin.move_fingers(lambda s: reached if s >= length else start + sign * s, profile)
        final = MotionState.DONE if reached == opening else MotionState.BLOCKED
        return lambda: MotionState.MOVING if self.cell.now() < end - _ROUNDING else final

    def stop(self) -> None:
        """Brake."""
        twin = self.cell.twin
        twin.remember()
        twin.fingers.stop(self.cell.now(), self.options.acceleration)

    def opening(self) -> Reading[float]:
        """Return the opening, m."""
        now = self.cell.now()
        return sample(self.cell.twin.fingers.at(now), now)
