"""Where frames come from: a camera, a recording, or librealsense's software device fed by a stand-in.

All three are devices of librealsense whose depth sensor hands its frames to a syncer, and all three can be recorded.
"""

from __future__ import annotations

import gc
import select
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Intrinsics
from stretch_bt.hardware.realsense.judge import TimedFrame
from stretch_bt.hardware.realsense.library import library
from stretch_bt.hardware.realsense.messages import CameraSettings
from stretch_bt.hardware.realsense.wire import CameraDescription, Packets, SentFrame

__all__ = ["Source", "open_source"]

_CONNECTING = 2.0
_PART = 1 << 20
_PAUSE = 0.002
#: how long librealsense may take to hand a frame that it was given through its syncer, s
_THROUGH = 0.2


class Source:
    """The depth sensor of a device, and the syncer that collects its frames."""

    def __init__(self, device: Any, settings: CameraSettings) -> None:
        self._rs = library()
        self._device = device if settings.record is None else self._recorded(device, Path(settings.record))
        self._sensor, self._profile = self._stream(settings)
        self.unit = float(self._sensor.get_option(self._rs.option.depth_units))
        self.intrinsics = _intrinsics(self._rs, self._profile)
        self._syncer = self._rs.syncer()

    @property
    def ended(self) -> bool:
        """Whether no frame will ever come again."""
        return False

    @property
    def broken(self) -> int:
        """Number of frames that came broken; librealsense reports none."""
        return 0

    def start(self) -> None:
        """Begin to stream."""
        self._sensor.open(self._profile)
        self._sensor.start(self._syncer)

    def shots(self, within: float) -> Iterator[TimedFrame]:
        """Yield the frames that come within a time, s, which ends also while more come than are taken."""
        end = time.monotonic() + within
        while True:
            frames = self._syncer.poll_for_frames()
            if frames and frames.size():
                yield self._shot(frames)
            else:
                time.sleep(_PAUSE)
            if time.monotonic() >= end:
                return

    def stop(self) -> None:
        """End the stream; a recording is whole once nothing refers to its device any more."""
        self._sensor.stop()
        self._sensor.close()
        for name in ("_device", "_sensor", "_profile", "_syncer"):
            delattr(self, name)
        gc.collect()

    def _shot(self, frames: Any) -> TimedFrame:
        frame = frames.get_depth_frame()
        image = np.array(np.asanyarray(frame.get_data()), dtype=np.uint16)
        return TimedFrame(int(frame.get_frame_number()), 1e-3 * frame.get_timestamp(), time.monotonic(), image)

    def _recorded(self, device: Any, folder: Path) -> Any:
        """Return the device with a recorder around it; the name that its file must have depends on the version."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OSError(f"no folder can be made at {folder} ({error.strerror}): correct `record`") from error
        stem = folder / f"{time.strftime('%Y%m%d-%H%M%S')}-{time.monotonic_ns() // 1_000_000 % 1000:03d}"
        try:
            return self._rs.recorder(f"{stem}.bag", device)
        except RuntimeError as error:
            if ".db3" not in str(error):
                raise
            return self._rs.recorder(f"{stem}.db3", device)

    def _stream(self, settings: CameraSettings) -> tuple[Any, Any]:
        """Return the sensor that has the depth stream that is asked for, and its profile."""
        found = []
        for sensor in self._device.query_sensors():
            for profile in sensor.get_stream_profiles():
                if profile.stream_type() == self._rs.stream.depth and profile.format() == self._rs.format.z16:
                    video = profile.as_video_stream_profile()
                    shape = (video.width(), video.height(), profile.fps())
                    if settings.serial is None or shape == (settings.width, settings.height, round(settings.rate)):
                        return sensor, profile
                    found.append("{} x {} at {} Hz".format(*shape))
        raise OSError(
            f"it has no depth stream of {settings.width} x {settings.height} at {settings.rate:g} Hz, "
            f"but {', '.join(dict.fromkeys(found)) or 'none'}: correct width, height and rate"
        )


class _Played(Source):
    """A recording, at its own pace."""

    def __init__(self, settings: CameraSettings) -> None:
        rs = library()
        self._statuses: list[Any] = []
        super().__init__(rs.context().load_device(settings.file), settings)
        playback = self._device if isinstance(self._device, rs.playback) else self._device.as_playback()
        playback.set_status_changed_callback(self._statuses.append)

    @property
    def ended(self) -> bool:
        """Whether the last frame has been played."""
        return self._rs.playback_status.stopped in self._statuses


class _Fed(Source):
    """The software device, fed with what a stand-in sends."""

    def __init__(self, settings: CameraSettings) -> None:
        library()  # before frames come, which would wait meanwhile and be taken for quick ones
        address = (settings.host, settings.port)
        try:
            self._wire = socket.create_connection(address, timeout=_CONNECTING)
        except OSError as error:
            raise OSError(f"nobody answers at {settings.host} port {settings.port} ({error})") from error
        self._packets = Packets()
        self._told = self._hello()
        self._wire.setblocking(False)
        device, self._inlet, self._inlet_profile = _software_device(self._told)
        super().__init__(device, settings)

    @property
    def broken(self) -> int:
        """How many packets had a wrong checksum."""
        return self._packets.broken

    def shots(self, within: float) -> Iterator[TimedFrame]:
        """Yield the frames that have come, waiting for one for a time, s."""
        if not select.select([self._wire], [], [], within)[0]:
            return
        for packet in self._packets.feed(_received(self._wire)):
            if isinstance(packet, SentFrame):
                self._feed(packet)
                came, frames = self._syncer.try_wait_for_frames(int(1e3 * _THROUGH))
                if not came:
                    raise OSError("librealsense lost a frame")
                yield self._shot(frames)

    def stop(self) -> None:
        """End the stream, and the connection."""
        self._wire.close()
        del self._inlet, self._inlet_profile
        super().stop()

    def _hello(self) -> CameraDescription:
        end = time.monotonic() + _CONNECTING
        while time.monotonic() < end:
            try:
                packets = list(self._packets.feed(_received(self._wire)))
            except TimeoutError:
                continue
            if packets and isinstance(packets[0], CameraDescription):
                return packets[0]
            if packets:
                break
        raise OSError("what answers does not describe itself as a camera")

    def _feed(self, picture: SentFrame) -> None:
        told, rs = self._told, self._rs
        if len(picture.pixels) != 2 * told.width * told.height:
            raise InvalidInput(f"a frame of {len(picture.pixels)} bytes is none of {told.width} x {told.height}")
        frame = rs.software_video_frame()
        frame.stride, frame.bpp = 2 * told.width, 2
        frame.timestamp, frame.frame_number = 1e3 * picture.time, picture.number
        frame.domain, frame.profile = rs.timestamp_domain.hardware_clock, self._inlet_profile.as_video_stream_profile()
        if hasattr(frame, "depth_units"):  # not in the version that has the SR305
            frame.depth_units = told.unit
        frame.pixels = np.frombuffer(picture.pixels, np.uint16).reshape(told.height, told.width)
        self._inlet.on_video_frame(frame)


def _received(wire: socket.socket) -> bytes:
    data = wire.recv(_PART)
    if not data:
        raise OSError("the stand-in closed the connection")
    return data


def _software_device(told: CameraDescription) -> tuple[Any, Any, Any]:
    """Return a device, its sensor, and the profile of its stream."""
    rs = library()
    lens = rs.intrinsics()
    lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy = (
        told.width,
        told.height,
        told.fx,
        told.fy,
        told.cx,
        told.cy,
    )
    lens.model, lens.coeffs = rs.distortion.inverse_brown_conrady, list(told.distortion)
    stream = rs.video_stream()
    stream.type, stream.index, stream.uid = rs.stream.depth, 0, 0
    stream.width, stream.height, stream.fps, stream.bpp = told.width, told.height, told.rate, 2
    stream.fmt, stream.intrinsics = rs.format.z16, lens
    device = rs.software_device()
    device.register_info(rs.camera_info.serial_number, told.serial)
    device.register_info(rs.camera_info.name, "stand-in")
    sensor = device.add_sensor("Depth")
    profile = sensor.add_video_stream(stream)
    sensor.add_read_only_option(rs.option.depth_units, told.unit)
    return device, sensor, profile


def _camera(serial: str) -> Any:
    rs = library()
    found = {d.get_info(rs.camera_info.serial_number): d for d in rs.context().query_devices()}
    if serial not in found:
        raise OSError(f"no camera has the serial number {serial}; connected: {', '.join(found) or 'none'}")
    return found[serial]


def _intrinsics(rs: Any, profile: Any) -> Intrinsics:
    """Return the intrinsics that the device reports; raises OSError for a distortion that is not understood."""
    lens = profile.as_video_stream_profile().get_intrinsics()
    known = lens.model in (rs.distortion.none, rs.distortion.inverse_brown_conrady)
    if not known and any(lens.coeffs):
        raise OSError(f"its lens has the distortion {lens.model}, of which only inverse Brown-Conrady is understood")
    k1, k2, p1, p2, k3 = (float(c) for c in lens.coeffs)
    return Intrinsics(lens.fx, lens.fy, lens.ppx, lens.ppy, lens.width, lens.height, (k1, k2, p1, p2, k3))


def open_source(settings: CameraSettings) -> Source:
    """Return what the settings name, not yet started; raises OSError, InvalidInput or RuntimeError where it cannot be had."""
    if settings.file is not None:
        return _Played(settings)
    if settings.host is not None:
        return _Fed(settings)
    assert settings.serial is not None
    return Source(_camera(settings.serial), settings)
