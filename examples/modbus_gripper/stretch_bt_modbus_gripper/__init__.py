"""A parallel gripper by Modbus TCP: `use: two_jaw` in a cell file."""

from stretch_bt_modbus_gripper.driver import TwoJawGripper

__all__ = ["TwoJawGripper"]
