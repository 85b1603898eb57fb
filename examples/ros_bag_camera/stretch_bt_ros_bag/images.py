"""ROS messages as depth frames have them (REP 118: 16UC1 in millimetres, 32FC1 in metres)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.devices import Intrinsics

#: of an encoding: type of a pixel, and the length of one count of the frame, m
UNITS = {"16UC1": (np.uint16, 1e-3), "mono16": (np.uint16, 1e-3), "32FC1": (np.float32, 1e-4)}


def seconds(stamp: Any) -> float:
    """Return a stamp of a header, s."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def counts(image: Any) -> tuple[npt.NDArray[np.uint16], float]:
    """Return the pixels of an Image in an array of their own, and the unit, m; raises ValueError for another encoding."""
    if image.encoding not in UNITS:
        raise ValueError(f"its pictures are {image.encoding}, of which only {', '.join(UNITS)} are depth")
    kind, unit = UNITS[image.encoding]
    pixel = np.dtype(kind).newbyteorder(">" if image.is_bigendian else "<")
    rows = np.frombuffer(bytes(image.data), np.uint8).reshape(image.height, image.step)
    values = np.ascontiguousarray(rows[:, : image.width * pixel.itemsize]).view(pixel)
    if kind is np.float32:  # NaN, infinite and too far are pixels without a depth
        far = np.where(np.isfinite(values), values / unit, 0.0)
        values = np.where(far < np.iinfo(np.uint16).max, np.rint(far), 0)
    return values.astype(np.uint16), unit


def lens(info: Any) -> Intrinsics:
    """Return the intrinsics of a CameraInfo; raises ValueError for a lens whose pictures are not rectified."""
    if any(info.d):
        raise ValueError("its pictures are not rectified; record the topic of rectified ones, such as image_rect_raw")
    k = [float(v) for v in info.k]
    return Intrinsics(k[0], k[4], k[2], k[5], int(info.width), int(info.height))
