"""A simulated cell on a clock that is moved by hand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.hardware.cell import Cell, open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import Motion, MotionState
from stretch_bt.perception import average_frames, mask_membrane
from stretch_bt.simulation.scene import Scene

__all__ = ["Bench"]

_STEP = 0.5  # s between looks at a motion, which cost a solve each
_PERIOD = 1 / 30  # s between frames


class Bench:
    """A cell in which a hand is moved, and time passes, only on request."""

    def __init__(self, scene: Scene, seed: int) -> None:
        self.time = 0.0
        self.scene = scene
        self.cell: Cell = open_cell(load_cell("simulated"), now=lambda: self.time, seed=seed, scene=scene)
        self.devices: dict[str, Any] = dict(self.cell.devices)

    def stretch(self, stretch: float) -> None:
        """Stretch the membrane, m."""
        opening = self.cell.hand.geometry.opening(stretch)
        self.wait(self.devices["gripper"].move(opening, speed=0.1, owner="bench"))

    def go(self, pose: Pose, speed: float) -> None:
        """Move the hand, at a speed, m/s."""
        self.wait(self.devices["arm"].move(pose, speed=speed, owner="bench"))

    def wait(self, motion: Motion) -> None:
        """Let time pass until a motion has ended."""
        while (state := motion.poll()) is MotionState.MOVING:
            self.time += _STEP
        if state is not MotionState.DONE:
            raise NoEquilibrium(f"the hand did not get where it was sent: {state}")

    def shots(self, count: int) -> Iterator[DepthFrame]:
        """Yield the next frames, as a node sees them: masked to the membrane."""
        geometry = self.cell.hand.geometry
        for _ in range(count):
            self.time += _PERIOD
            shot = self.devices["camera"].frame(1.0).value
            yield mask_membrane(shot, gauge=geometry.gauge, width=geometry.width, stretch=shot.stretch or 0.0)

    def frame(self, count: int) -> DepthFrame:
        """Return the mean of the next frames."""
        return average_frames(list(self.shots(count)))

    def force(self, count: int) -> float:
        """Return the mean force along z, N, of the next readings."""
        found = []
        for _ in range(count):
            self.time += 1e-3
            found.append(self.devices["force_sensor"].wrench(1.0).value.force[2])
        return float(sum(found) / count)
