"""Depth images in record.mcap: each stored once, however often it is handed out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.runtime.record.channels import Channels
from stretch_bt.runtime.record.messages import calibration, raw_image

__all__ = ["Images"]


@dataclass(slots=True)
class _Latest:
    """What was last stored of one camera."""

    image: int = -1
    calibration: int = -1
    raw: npt.NDArray[np.uint16] | None = None
    intrinsics: Intrinsics | None = None


class Images:
    """Stores the images and calibrations of all cameras and numbers them."""

    def __init__(self, channels: Channels) -> None:
        self._channels = channels
        self._latest: dict[str, _Latest] = {}

    def store(self, device: str, frame: DepthFrame) -> dict[str, int]:
        """Return the numbers of a frame's image and calibration, stored now where they are new."""
        latest = self._latest.setdefault(device, _Latest())
        now = self._channels.now
        if latest.intrinsics != frame.intrinsics:
            latest.calibration += 1
            latest.intrinsics = frame.intrinsics
            message = calibration(frame.intrinsics, device, now)
            self._channels.proto(f"/{device}/calibration", message, latest.calibration)
        if latest.raw is None or not np.array_equal(latest.raw, frame.raw):
            latest.image += 1
            latest.raw = frame.raw.copy()  # a driver may reuse its buffer
            self._channels.proto(f"/{device}/depth", raw_image(frame.raw, device, now), latest.image)
        return {"image": latest.image, "calibration": latest.calibration}
