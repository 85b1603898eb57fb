"""How the hand stands while it presses."""

from __future__ import annotations

from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Arm, Gripper

__all__ = ["pressed"]

MAX_AGE = 0.5


def pressed(hand: Hand, arm: Arm, gripper: Gripper) -> tuple[float, float]:
    """Return stretch and depth past first contact, m, as gripper and arm tell them; raises NoContact before `approach` found it."""
    depth = hand.touched_at - arm.pose(MAX_AGE).value.height
    return hand.geometry.stretch(gripper.opening(MAX_AGE).value), depth
