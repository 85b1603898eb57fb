"""Foxglove's messages, which its app and Rerun open as they are: images, calibrations, point clouds, log lines."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics

__all__ = ["calibration", "intrinsics_of", "log_line", "point_cloud", "raw_image", "raw_of"]


def _stamp(now: int) -> Any:
    from google.protobuf.timestamp_pb2 import Timestamp

    return Timestamp(seconds=now // 1_000_000_000, nanos=now % 1_000_000_000)


def raw_image(raw: npt.NDArray[np.uint16], device: str, now: int) -> Any:
    """Return a foxglove.RawImage of (h, w) uint16 counts, at `now` ns."""
    from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

    height, width = raw.shape
    data = raw.astype("<u2", copy=False).tobytes()
    return RawImage(
        timestamp=_stamp(now), frame_id=device, width=width, height=height, encoding="16UC1", step=2 * width, data=data
    )


def raw_of(data: bytes) -> npt.NDArray[np.uint16]:
    """Return the (h, w) uint16 counts of a serialised foxglove.RawImage."""
    from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

    image = RawImage.FromString(data)
    return np.frombuffer(image.data, "<u2").astype(np.uint16).reshape(image.height, image.width)


def calibration(intrinsics: Intrinsics, device: str, now: int) -> Any:
    """Return a foxglove.CameraCalibration of a depth camera, at `now` ns."""
    from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration

    fx, fy, cx, cy = intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy
    # Viewers refuse an image whose distortion they cannot undo; without distortion any model will do.
    model = "inverse_brown_conrady" if any(intrinsics.distortion) else "plumb_bob"
    return CameraCalibration(
        timestamp=_stamp(now),
        frame_id=device,
        width=intrinsics.width,
        height=intrinsics.height,
        distortion_model=model,
        D=intrinsics.distortion,
        K=[fx, 0, cx, 0, fy, cy, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0],
    )


def intrinsics_of(data: bytes) -> Intrinsics:
    """Return the intrinsics of a serialised foxglove.CameraCalibration."""
    from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration

    found = CameraCalibration.FromString(data)
    fx, cx, fy, cy = found.K[0], found.K[2], found.K[4], found.K[5]
    return Intrinsics(fx, fy, cx, cy, found.width, found.height, tuple(found.D))


def point_cloud(points: npt.NDArray[np.floating[Any]], frame: str, now: int) -> Any:
    """Return a foxglove.PointCloud of (n, 3) points, m, at `now` ns."""
    from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

    float32 = PackedElementField.FLOAT32
    fields = [PackedElementField(name=name, offset=4 * i, type=float32) for i, name in enumerate("xyz")]
    data = points.astype("<f4").tobytes()
    return PointCloud(timestamp=_stamp(now), frame_id=frame, point_stride=12, fields=fields, data=data)


def log_line(level: str, name: str, text: str, now: int) -> Any:
    """Return a foxglove.Log at `now` ns; `level` is INFO, WARNING or ERROR."""
    from foxglove_schemas_protobuf.Log_pb2 import Log

    return Log(timestamp=_stamp(now), level=Log.Level.Value(level), name=name, message=text)
