"""A force sensor that plays recorded wrenches."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from pydantic import Field

from stretch_bt.frames import Wrench
from stretch_bt.hardware.driver import Mistake, Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.replay.npz import npz_mistakes
from stretch_bt.hardware.replay.sixes import PlaysSixes, Sixes
from stretch_bt.hardware.zeroed import ZeroedForceSensor

__all__ = ["ReplayForceSensor"]


class _Options(Options):
    type: Literal["ForceSensor"]
    use: Literal["replay"]
    file: str = Field(description="npz file, relative to the cell file")
    wrench: str = Field(default="wrench", description="name of the (n, 6) array of force, N, and torque, N m")
    time: str = Field(default="t", description="name of the (n,) array of times, s")

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield what is wrong with the file."""
        yield from npz_mistakes(
            root,
            "file",
            self.file,
            {"wrench": self.wrench, "time": self.time},
            lambda: Sixes("sensor", root / self.file, self.time, [self.wrench], lambda: 0.0),
        )


class ReplayForceSensor(PlaysSixes, ZeroedForceSensor):
    """Plays recorded wrenches from the moment it is opened; then it is lost: end of recording."""

    Options = _Options

    def open(self) -> None:
        """Read the recording and begin to play it."""
        self.play(self.options.wrench)

    def raw(self) -> Reading[Wrench]:
        """Return the recorded wrench; raises DeviceLost at the end of the recording."""
        return self.latest_wrench()
