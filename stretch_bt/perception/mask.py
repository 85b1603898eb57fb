"""Isolating the membrane: a box in the plane of the flat membrane that follows the gripper."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind, check_numbers
from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception.deprojection import ray_table
from stretch_bt.perception.types import FRAME

__all__ = ["LARGEST", "mask_membrane"]

LARGEST = 2.0  # m, of any side of a membrane; lengths in mm exceed it
MARGIN = 0.004  # m inside the edges, where depth cameras mix membrane and background


def mask_membrane(frame: DepthFrame, *, gauge: float, width: float, stretch: float) -> DepthFrame:
    """Return the frame with every pixel that does not look at the membrane made invalid.

    The box is (gauge + stretch) long. Its sides are free and draw in as the membrane is pulled: an incompressible sheet
    in uniaxial tension keeps width / sqrt(1 + stretch / gauge).

    Raises
    ------
    InvalidInput
        The frame does not say how far the flat membrane is, or a length is not positive, or above 2 m, as millimetres are.
    """
    check_kind("frame", frame, DepthFrame, FRAME)
    check_numbers("in m", gauge=gauge, width=width, stretch=stretch)
    if frame.plane_distance is None:
        raise InvalidInput("a box mask needs a frame with plane_distance, the distance to the flat membrane")
    if not (gauge > 0 and width > 0 and gauge + stretch > 0):
        raise InvalidInput(f"gauge, width and length must be positive, got {gauge}, {width} and {gauge + stretch} m")
    if max(gauge, width, gauge + stretch) > LARGEST:
        raise InvalidInput(
            f"gauge, width and stretch are in m, and no side of a membrane is above {LARGEST:g} m, got {gauge:g}, {width:g} and {stretch:g};"
            " write 0.09 for 90 mm"
        )
    half_length = 0.5 * (gauge + stretch) - MARGIN
    half_width = 0.5 * width / math.sqrt((gauge + stretch) / gauge) - MARGIN
    inside = _box(frame.intrinsics, half_length / frame.plane_distance, half_width / frame.plane_distance)
    return replace(frame, raw=frame.raw * inside)


@lru_cache(maxsize=8)
def _box(intrinsics: Intrinsics, half_length: float, half_width: float) -> npt.NDArray[np.bool_]:
    """Return which pixels look into a box, its half sides at unit depth."""
    rays = ray_table(intrinsics)
    return np.asarray((np.abs(rays[..., 0]) <= half_width) & (np.abs(rays[..., 1]) <= half_length))
