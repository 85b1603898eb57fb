"""How the hand stands while it presses."""

from __future__ import annotations

from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.interfaces import Arm, Gripper

__all__ = ["pressed"]

MAX_AGE = 0.5


def pressed(hand: HandGeometry, touch: Touch, arm: Arm, gripper: Gripper) -> tuple[float, float]:
    """Return stretch and depth past first contact, m, as gripper and arm measure them."""
    depth = touch.height - arm.pose(MAX_AGE).value.height
    return hand.stretch(gripper.opening(MAX_AGE).value), depth
