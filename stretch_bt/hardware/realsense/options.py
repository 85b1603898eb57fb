"""Options of a RealSense camera in a cell file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.address import Address
from stretch_bt.hardware.driver import Mistake, Options, missing_file
from stretch_bt.hardware.realsense.messages import CameraSettings
from stretch_bt.hardware.realsense.wire import PORT
from stretch_bt.units import KINDS, Length, Time
from stretch_bt.within import Within

__all__ = ["RealsenseOptions"]

_Pixels = Annotated[int, Field(ge=1, le=4096)]
_Rate = Annotated[float, KINDS["Frequency"], Within(1.0, 300.0, "Frequency")]


class RealsenseOptions(Options):
    """Where the frames come from, and when the camera counts as lost."""

    type: Literal["DepthCamera"]
    use: Literal["realsense"]
    serial: str | None = Field(
        default=None, min_length=1, description="serial number of the camera; or `file`, or `host`"
    )
    file: str | None = Field(
        default=None, min_length=1, description="recording of librealsense to play, relative to the cell file"
    )
    host: Address | None = Field(default=None, description="address of the stand-in `stretch-bt emulate realsense`")
    port: Annotated[int, Within(1, 65535)] = Field(default=PORT, description="port of that host")
    width: _Pixels = Field(default=640, description="width of the depth stream that a camera is asked for")
    height: _Pixels = 480
    rate: _Rate = Field(default=30.0, description="rate of that stream")
    latency: Annotated[Time, Within(0.0, 0.5, "Time")] = Field(
        default=0.04, description="least time from exposure to arrival; a frame counts as that much older"
    )
    lost_after: Annotated[Time, Within(0.1, 10.0, "Time")] = Field(
        default=0.4, description="time without a good frame after which the camera counts as lost"
    )
    noisy: bool = Field(
        default=True,
        description="whether no two images are alike, so that one that stands or is torn is found; false where there is no noise",
    )
    record: str | None = Field(
        default=None, min_length=1, description="folder, relative to the cell file, for a recording of all frames"
    )
    plane_distance: Annotated[Length, Within(0.01, 10.0, "Length")] | None = Field(
        default=None, description="distance from the camera to the flat membrane, in place of the one in `hand`"
    )

    @model_validator(mode="after")
    def _one_source(self) -> RealsenseOptions:
        given = [name for name in ("serial", "file", "host") if getattr(self, name) is not None]
        if len(given) != 1:
            said = "none is given" if not given else f"{' and '.join(given)} are given"
            raise InvalidInput(
                f"frames come from one camera, recording or stand-in, and {said}; write one of 'serial: ...', 'file: ...' and 'host: ...'"
            )
        if self.file is not None and self.record is not None:
            raise InvalidInput("a recording is not recorded again; leave out 'record' or 'file'")
        return self

    def settings(self, root: Path) -> CameraSettings:
        """Return what the process of the camera goes by."""
        paths = {k: v and str(root.absolute() / v) for k, v in (("file", self.file), ("record", self.record))}
        return CameraSettings(**{f.name: getattr(self, f.name) for f in fields(CameraSettings)} | paths)

    @property
    def place(self) -> str:
        """Where the frames come from, for messages."""
        if self.serial is not None:
            return f"serial number {self.serial}"
        return f"the recording {self.file}" if self.file is not None else f"{self.host} port {self.port}"

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield that the recording is not there, and that a camera is lost between two of its frames."""
        if self.file is not None:
            yield from missing_file(root, "file", self.file)
        if self.serial is not None and self.lost_after <= 1 / self.rate:
            told = f"frames that come {self.rate:g} times a second are {1e3 / self.rate:.4g} ms apart"
            yield "lost_after", told, f"write more than {1e3 / self.rate:.4g} ms, or a higher `rate`"
