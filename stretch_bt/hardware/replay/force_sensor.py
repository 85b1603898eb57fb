"""A force sensor that plays recorded wrenches."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from pydantic import Field

from stretch_bt.frames import Wrench
from stretch_bt.hardware.driver import ForceSensorDriver, Mistake, Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.replay.npz import npz_mistakes
from stretch_bt.hardware.replay.sixes import Sixes, opened
from stretch_bt.hardware.wrenches import minus

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


class ReplayForceSensor(ForceSensorDriver):
    """Plays recorded wrenches from the moment it is opened; then it is lost: end of recording."""

    Options = _Options
    any_clock = True
    _played: Sixes | None = None
    _zero = Wrench((0.0, 0.0, 0.0))

    @property
    def ended(self) -> bool:
        """Whether the last wrench has had its time."""
        return self._played is not None and self._played.tape.ended

    def open(self) -> None:
        """Read the recording and begin to play it."""
        o: _Options = self.options
        self._played = Sixes(self.name, self.cell.root / o.file, o.time, [o.wrench], self.cell.now)

    def close(self) -> None:
        """Forget where it stood."""
        self._played = None

    def wrench(self) -> Reading[Wrench]:
        """Return the wrench since the last `zero`; raises DeviceLost at the end of the recording."""
        return minus(self._raw(), self._zero)

    def zero(self) -> None:
        """Take the present wrench as zero."""
        self._zero = self._raw().value

    def _raw(self) -> Reading[Wrench]:
        force, torque, time, due, number = opened(self.name, self._played).latest(self.options.wrench)
        return Reading(Wrench(force, torque), time, due, number)
