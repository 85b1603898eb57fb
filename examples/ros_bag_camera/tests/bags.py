"""Writes small bags: a membrane that an object touches and leaves."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
TOPIC, INFO = "/camera/depth/image_rect_raw", "/camera/depth/camera_info"
#: of the stamps of the bag, s
TAKEN = 1_700_000_000.0


def write_bag(
    path: Path, pictures: Iterable[npt.NDArray[np.uint16]], *, focal: float = 60.0, rate: float = 30.0
) -> Path:
    """Write pictures of millimetres, and the lens that took them."""
    types = STORE.types
    Time, Header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    Image, Info, Roi = (types[f"sensor_msgs/msg/{n}"] for n in ("Image", "CameraInfo", "RegionOfInterest"))
    with Writer(path, version=9) as writer:
        images = writer.add_connection(TOPIC, Image.__msgtype__, typestore=STORE)
        infos = writer.add_connection(INFO, Info.__msgtype__, typestore=STORE)
        for number, picture in enumerate(pictures):
            stamp = round(1e9 * (TAKEN + number / rate))
            header = Header(Time(stamp // 10**9, stamp % 10**9), "camera_depth_optical_frame")
            rows, columns = picture.shape
            pixels = np.frombuffer(picture.astype("<u2").tobytes(), np.uint8)
            image = Image(header, rows, columns, "16UC1", 0, 2 * columns, pixels)
            k = np.array([focal, 0, columns / 2, 0, focal, rows / 2, 0, 0, 1])
            p = np.array([focal, 0, columns / 2, 0, 0, focal, rows / 2, 0, 0, 0, 1, 0])
            info = Info(
                header, rows, columns, "plumb_bob", np.zeros(5), k, np.eye(3).ravel(), p, 0, 0, Roi(0, 0, 0, 0, False)
            )
            writer.write(infos, stamp, STORE.serialize_cdr(info, Info.__msgtype__))
            writer.write(images, stamp, STORE.serialize_cdr(image, Image.__msgtype__))
    return path
