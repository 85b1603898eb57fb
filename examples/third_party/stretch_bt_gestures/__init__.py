"""Nodes for objects that relax under a press."""

from stretch_bt_gestures.force_loss import ForceLoss
from stretch_bt_gestures.press_twice import PressTwice

__all__ = ["ForceLoss", "PressTwice"]
