"""What perception hands to the tree: a contact and a sphere, each number with its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.units import Curvature, Length, Time

__all__ = ["CONTACT", "DEFORMED", "INVALID", "UNDEFORMED", "Contact", "FloatArray", "LabelArray", "MaskArray", "Sphere"]

FloatArray = npt.NDArray[np.floating[Any]]
MaskArray = npt.NDArray[np.bool_]
LabelArray = npt.NDArray[np.uint8]

UNDEFORMED, DEFORMED, CONTACT, INVALID = 0, 1, 2, 255


@dataclass(frozen=True, slots=True)
class Contact:
    """The points of the membrane that touch the object, in one frame.

    `points` (n, 3), m, and unit `rays` (n, 3), from the camera through each point, are in the membrane frame. `labels`
    (h, w) uint8 holds the class of every pixel, `confidence` (h, w) float32 the probability that it is right, 0 where
    invalid, and `surface` (h, w, 3), m, membrane frame, its point, NaN where the label is 255. `noise` is the depth
    standard deviation of one pixel, m, as the frame itself shows it. `hand_height`, `stretch`, m, `time`, s, and
    `pose`, of the hand in the world, are those of the frame.
    """

    points: FloatArray
    rays: FloatArray
    labels: LabelArray
    noise: Length
    hand_height: Length | None
    stretch: Length | None
    time: Time
    surface: FloatArray
    confidence: FloatArray
    pose: Pose | None = None


@dataclass(frozen=True, slots=True)
class Sphere:
    """A fitted sphere; `radius` is positive, the sign of `curvature` is positive where it is convex to the camera.

    `center` and `center_sd` are (3,), m, in the frame of the points that were fitted.
    """

    radius: Length
    radius_sd: Length
    center: FloatArray
    center_sd: FloatArray
    curvature: Curvature
    curvature_sd: Curvature
