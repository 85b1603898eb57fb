"""A camera that plays recorded depth frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from stretch_bt.errors import DeviceLost, InvalidInput, NotReady
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.driver import CellContext, DepthCameraDriver, Mistake, Options
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.replay.frames import FrameArray, FrameFolder, Frames, png_files
from stretch_bt.hardware.replay.npz import npz_mistakes, read_arrays
from stretch_bt.hardware.replay.tape import Tape
from stretch_bt.source.arrays import unread_array
from stretch_bt.units import Frequency, Length
from stretch_bt.within import Within

__all__ = ["ReplayCamera"]

_Focal = Annotated[float, Within(1.0, 1e5)]
_Pixels = Annotated[int, Field(ge=1, le=100_000)]


class Pinhole(BaseModel):
    """Intrinsics of the whole image, pixels; the five coefficients are inverse Brown-Conrady."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    fx: _Focal
    fy: _Focal
    cx: Annotated[float, Within(-1e5, 1e5)]
    cy: Annotated[float, Within(-1e5, 1e5)]
    distortion: list[float] = Field(default=[0.0] * 5, min_length=5, max_length=5)


class _Options(Options):
    type: Literal["DepthCamera"]
    use: Literal["replay"]
    file: str | None = Field(default=None, description="npz file, relative to the cell file")
    folder: str | None = Field(default=None, description="folder of 16-bit PNG files, relative to the cell file")
    depth: str | None = Field(default=None, description="name of the (n, h, w) uint16 array in the file")
    time: str | None = Field(
        default=None, description="name of the (n,) array of times, s, in the file; else `rate` holds"
    )
    rate: Annotated[Frequency, Within(0.01, 1000.0, "Frequency")] = Field(
        default=30.0, description="rate of the files of a folder"
    )
    unit: Annotated[Length, Within(1e-6, 0.01, "Length")] = Field(description="one count of depth")
    intrinsics: str | Pinhole = Field(description="name of an array fx, fy, cx, cy in the file, or the values")
    roi: str | None = Field(
        default=None, description="name of an array v0, v1, u0, u1: the part of the image that was kept"
    )
    width: _Pixels = Field(default=640, description="width of the whole image")
    height: _Pixels = Field(default=480, description="height of the whole image")
    plane_distance: Annotated[Length, Within(0.01, 10.0, "Length")] | None = None

    @model_validator(mode="after")
    def _one_source(self) -> _Options:
        if (self.file is None) == (self.folder is None):
            raise InvalidInput("a recording is one file or one folder; write one of 'file: ...' and 'folder: ...'")
        if self.file is not None and self.depth is None:
            raise InvalidInput("which array of the file holds the images is not said; add 'depth: NAME'")
        if self.folder is not None and (self.depth or self.time or self.roi or isinstance(self.intrinsics, str)):
            raise InvalidInput("a folder of images holds no arrays; give intrinsics as 'fx, fy, cx, cy', and 'rate'")
        return self

    def arrays(self) -> dict[str, str | None]:
        """Return the array that each option names."""
        intrinsics = self.intrinsics if isinstance(self.intrinsics, str) else None
        return {"depth": self.depth, "time": self.time, "roi": self.roi, "intrinsics": intrinsics}

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield what is wrong with the file or folder."""
        if self.file is not None:
            begin = partial(ReplayCamera.rehearse, self, root)
            yield from npz_mistakes(root, "file", self.file, self.arrays(), begin)
        elif self.folder is not None and not png_files(root / self.folder):
            yield "folder", f"there are no PNG files in {self.folder!r}", "write a folder relative to the cell file"


class ReplayCamera(DepthCameraDriver):
    """Plays a recording from the moment it is opened, at its own pace; then it is lost: end of recording."""

    Options = _Options
    any_clock = True
    _tape: Tape | None = None
    _latest: Reading[DepthFrame] | None = None

    @property
    def ended(self) -> bool:
        """Whether the last frame has had its time."""
        return self._tape is not None and self._tape.ended

    @cached_property
    def _arrays(self) -> dict[str, Any]:
        """The arrays of the file, but for the images, by option."""
        o: _Options = self.options
        wanted = {option: key for option, key in o.arrays().items() if key is not None and option != "depth"}
        if o.file is None or not wanted:
            return {}
        found = read_arrays(self.name, self.cell.root / o.file, list(wanted.values()))
        return {option: found[key] for option, key in wanted.items()}

    @cached_property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the part of the image that was recorded."""
        o: _Options = self.options
        if isinstance(o.intrinsics, Pinhole):
            p = o.intrinsics
            k1, k2, p1, p2, k3 = p.distortion
            whole = Intrinsics(p.fx, p.fy, p.cx, p.cy, o.width, o.height, (k1, k2, p1, p2, k3))
        else:
            fx, fy, cx, cy = self._four("intrinsics")
            whole = Intrinsics(fx, fy, cx, cy, o.width, o.height)
        return whole if o.roi is None else whole.cropped(*(int(v) for v in self._four("roi")))

    @classmethod
    def rehearse(cls, options: _Options, root: Path) -> None:
        """Begin to play a file without its images; raises DeviceLost."""
        now = float  # which gives 0.0
        camera = cls("camera", options, CellContext(now, 0, root, Hand(), Limits()))
        _, times = camera._source(unread_array)
        Tape(camera.name, times, now)

    def open(self) -> None:
        """Read the recording and begin to play it."""
        self._frames, times = self._source(lambda path, name: read_arrays(self.name, path, [name])[name])
        self._latest = None
        self._tape = Tape(self.name, times, self.cell.now)

    def close(self) -> None:
        """Forget where it stood."""
        self._tape = None

    def frame(self) -> Reading[DepthFrame]:
        """Return the latest frame; raises DeviceLost at the end of the recording."""
        if self._tape is None:
            raise NotReady(self.name, "the recording is not open")
        number, due = self._tape.latest()
        if self._latest is None or self._latest.sequence != number:
            self._latest = self._reading(number, due, float(self._tape.times[number]))
        return self._latest

    def _reading(self, number: int, due: float, time: float) -> Reading[DepthFrame]:
        distance = self.options.plane_distance
        raw = self._frames[number]
        frame = DepthFrame(raw, self.options.unit, self.intrinsics, time, number, plane_distance=distance)
        return Reading(frame, time, due, number)

    def _source(self, read: Callable[[Path, str], Any]) -> tuple[Frames, Any]:
        o: _Options = self.options
        shape = (self.intrinsics.height, self.intrinsics.width)
        if o.folder is not None:
            files = png_files(self.cell.root / o.folder)
            return FrameFolder(self.name, files, shape), np.arange(len(files)) / o.rate
        assert o.file is not None
        assert o.depth is not None
        images = read(self.cell.root / o.file, o.depth)
        count = images.shape[0] if images.ndim else 0
        times = self._arrays.get("time", np.arange(count) / o.rate)
        return FrameArray(self.name, images, len(np.atleast_1d(times)), shape), times

    def _four(self, option: str) -> tuple[float, float, float, float]:
        values = self._arrays[option]
        if values.shape != (4,) or not np.issubdtype(values.dtype, np.number) or not np.all(np.isfinite(values)):
            raise DeviceLost(self.name, f"{option} must be four finite numbers, the file has {values.tolist()}")
        a, b, c, d = (float(v) for v in values)
        return a, b, c, d
