"""The node library: perception, actuation and model nodes, one to a file of its name, found by being here."""

from stretch_bt.behaviors._motion import MotionBehavior

__all__ = ["MotionBehavior"]
