"""A simulated arm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import ArmDriver, Options, Poll
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.motion.path import PosePath
from stretch_bt.hardware.motion.profile import Profile
from stretch_bt.hardware.simulated.placed import Placed
from stretch_bt.hardware.simulated.samples import sample, sample_wrench
from stretch_bt.units import KINDS, Length
from stretch_bt.within import Within

__all__ = ["SimulatedArm"]

_Acceleration = Annotated[float, KINDS["Acceleration"], Within(0.01, 20.0, "Acceleration")]
_Place = Annotated[Length, Within(-2.0, 2.0, "Length")]
_TABLE = 0.0
_ROUNDING = 1e-9


class _Options(Options):
    type: Literal["Arm"]
    use: Literal["simulated"]
    acceleration: _Acceleration = Field(default=0.5, description="acceleration at the begin and the end of each motion")
    x: _Place = Field(default=0.0, description="place of the hand at first")
    y: _Place = 0.0
    height: Annotated[Length, Within(0.0, 2.0, "Length")] = 0.2


class SimulatedArm(ArmDriver):
    """Moves on a trapezoid of speed; the hand comes to rest on the table rather than enter it.

    A new command while it moves begins from rest where the hand then is. Each motion ends at a height that is off by the
    scene's repeatability, which the arm does not know.
    """

    Options = _Options
    simulated = any_clock = True
    _moves = 0
    _placed = False

    def open(self) -> None:
        """Stand at the home pose of the cell file at first, and later where it was left."""
        if not self._placed:
            o = self.options
            self.cell.twin.place(Pose((o.x, o.y, o.height)))
            self._placed = True

    def follow(self, path: Sequence[Pose], speed: float) -> Poll:
        """Move through the poses in straight lines, without stopping at them."""
        twin, now = self.cell.twin, self.cell.now()
        told, true = twin.hand.at(now)
        wanted = PosePath([told, *path])
        route = wanted.above(_TABLE)
        before, after = true.height - told.height, self._error()

        def place(distance: float) -> Placed:
            pose = route.at(distance)
            part = distance / route.length if route.length > 0 else 0.0
            return Placed(pose, pose.moved(z=before + part * (after - before)))

        profile = Profile.trapezoid(route.length, speed, self.options.acceleration)
        end = twin.move_hand(place, profile, route.corners)
        final = MotionState.DONE if route is wanted else MotionState.BLOCKED
        return lambda: MotionState.MOVING if self.cell.now() < end - _ROUNDING else final

    def stop(self) -> None:
        """Brake."""
        twin = self.cell.twin
        twin.remember()
        twin.hand.stop(self.cell.now(), self.options.acceleration)

    def pose(self) -> Reading[Pose]:
        """Return where the arm takes the hand to be."""
        now = self.cell.now()
        return sample(self.cell.twin.hand.at(now).told, now)

    def wrench(self) -> Reading[Wrench]:
        """Return the arm's estimate of the contact wrench."""
        return sample_wrench(self.cell.twin, "Arm", self.name)

    def _error(self) -> float:
        self._moves += 1
        twin = self.cell.twin
        error = 0.0
        for effect in twin.robot:
            with twin.world.stats.timed(effect.name):
                error += effect.height_error(twin.random(f"{self.name} {effect.name}", self._moves))
        return error
