"""A Robotiq 2F gripper by the socket of Robotiq's URCap."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from stretch_bt.hardware.address import Address
from stretch_bt.hardware.robotiq.driver import RobotiqDriver
from stretch_bt.hardware.robotiq.options import RobotiqOptions
from stretch_bt.hardware.robotiq.urcap_wire import UrcapWire
from stretch_bt.hardware.robotiq.wire import GripperWire
from stretch_bt.within import Within

__all__ = ["RobotiqUrcapGripper"]


class _UrcapOptions(RobotiqOptions):
    type: Literal["Gripper"]
    use: Literal["robotiq_urcap"]
    host: Address = Field(description="address of the robot's controller")
    port: Annotated[int, Within(1, 65535)] = 63352


class RobotiqUrcapGripper(RobotiqDriver):
    """A Robotiq 2F-85 or 2F-140 at the wrist of a robot, by the socket of Robotiq's URCap on the controller."""

    Options = _UrcapOptions
    options: _UrcapOptions

    def claimed(self) -> str:
        """Return where the gripper is."""
        return f"the gripper at {self.options.host} port {self.options.port}"

    def _wire(self) -> GripperWire:
        return UrcapWire(self.options.host, self.options.port, self.options.timeout)
