"""An arm that plays recorded poses and wrenches, and moves nowhere else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from stretch_bt.errors import DeviceLost, NotReady
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import ArmDriver, Mistake, Options, Poll
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.replay.npz import npz_mistakes, read_arrays
from stretch_bt.hardware.replay.tape import Tape

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
        yield from npz_mistakes(root, "file", self.file, keys)


class ReplayArm(ArmDriver):
    """Plays a recording from the moment it is opened; then it is lost: end of recording. Motions are refused."""

    Options = _Options
    _tape: Tape | None = None

    @property
    def ended(self) -> bool:
        """Whether the last pose has had its time."""
        return self._tape is not None and self._tape.ended

    def open(self) -> None:
        """Read the recording and begin to play it."""
        o: _Options = self.options
        found = read_arrays(self.name, self.bench.root / o.file, [o.pose, o.wrench, o.time])
        tape = Tape(self.name, found[o.time], self.bench.now)
        for key in (o.pose, o.wrench):
            if found[key].shape != (tape.times.size, 6) or not np.all(np.isfinite(found[key])):
                told = f"{key} must be ({tape.times.size}, 6) and finite, it is {found[key].shape}"
                raise DeviceLost(self.name, told)
        self._poses, self._wrenches, self._tape = found[o.pose], found[o.wrench], tape

    def close(self) -> None:
        """Forget where it stood."""
        self._tape = None

    def unready(self) -> str:
        """Return that it cannot be moved."""
        return "a recording cannot be moved; run a tree that only reads it"

    def follow(self, path: Sequence[Pose], speed: float) -> Poll:
        """Raise NotReady: where it goes is recorded."""
        raise NotReady(self.name, self.unready())

    def pose(self) -> Reading[Pose]:
        """Return the pose; raises DeviceLost at the end of the recording."""
        number, due, time = self._latest()
        return Reading(Pose(*_halves(self._poses[number])), time, due, number)

    def wrench(self) -> Reading[Wrench]:
        """Return the wrench; raises DeviceLost at the end of the recording."""
        number, due, time = self._latest()
        return Reading(Wrench(*_halves(self._wrenches[number])), time, due, number)

    def _latest(self) -> tuple[int, float, float]:
        if self._tape is None:
            raise NotReady(self.name, "the recording is not open")
        number, due = self._tape.latest()
        return number, due, float(self._tape.times[number])


def _halves(six: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    a, b, c, d, e, f = (float(v) for v in six)
    return (a, b, c), (d, e, f)
