"""An arm that plays recorded poses and wrenches, and moves nowhere else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field

from stretch_bt.errors import NotReady
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import ArmDriver, Mistake, Options, Poll
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.replay.npz import npz_mistakes
from stretch_bt.hardware.replay.sixes import PlaysSixes, Sixes

__all__ = ["ReplayArm"]


class _Options(Options):
    type: Literal["Arm"]
    use: Literal["replay"]
    file: str = Field(description="npz file, relative to the cell file")
    pose: str = Field(default="pose", description="name of the (n, 6) array of position, m, and rotation vector, rad")
    wrench: str = Field(default="wrench", description="name of the (n, 6) array of force, N, and torque, N m")
    time: str = Field(default="t", description="name of the (n,) array of times, s")

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield what is wrong with the file."""
        keys: dict[str, str | None] = {"pose": self.pose, "wrench": self.wrench, "time": self.time}
        yield from npz_mistakes(
            root,
            "file",
            self.file,
            keys,
            lambda: Sixes("arm", root / self.file, self.time, [self.pose, self.wrench], lambda: 0.0),
        )


class ReplayArm(PlaysSixes, ArmDriver):
    """Plays a recording from the moment it is opened; then it is lost: end of recording. Motions are refused."""

    Options = _Options

    def open(self) -> None:
        """Read the recording and begin to play it."""
        self.play(self.options.pose, self.options.wrench)

    def unready(self) -> str:
        """Return that it cannot be moved."""
        return "a recording cannot be moved; run a tree that only reads it"

    def follow(self, path: Sequence[Pose], speed: float) -> Poll:
        """Raise NotReady: where it goes is recorded."""
        raise NotReady(self.name, self.unready())

    def pose(self) -> Reading[Pose]:
        """Return the pose; raises DeviceLost at the end of the recording."""
        return self.latest_pose()

    def wrench(self) -> Reading[Wrench]:
        """Return the wrench; raises DeviceLost at the end of the recording."""
        return self.latest_wrench()
