"""A Robotiq 2F gripper by Modbus."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from stretch_bt.hardware.address import Address
from stretch_bt.hardware.driver import Mistake
from stretch_bt.hardware.robotiq.driver import RobotiqDriver
from stretch_bt.hardware.robotiq.modbus_wire import ModbusWire, serial_client, tcp_client
from stretch_bt.hardware.robotiq.options import RobotiqOptions
from stretch_bt.hardware.robotiq.wire import GripperWire
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.hardware.robotiq.modbus_wire import Client

__all__ = ["RobotiqGripper"]


class _ModbusOptions(RobotiqOptions):
    type: Literal["Gripper"]
    use: Literal["robotiq"]
    serial: str | None = Field(default=None, description="device of the serial line, such as `/dev/ttyUSB0`; or `host`")
    baudrate: Annotated[int, Within(1200, 921600)] = 115200
    host: Address | None = Field(default=None, description="address of a gateway, or of the robot's tool connector")
    port: Annotated[int, Within(1, 65535)] = Field(default=54321, description="port of that host")
    framing: Literal["rtu", "tcp"] = Field(
        default="rtu", description="form of messages to that host: RTU frames as they are, or Modbus TCP"
    )
    unit: Annotated[int, Within(1, 247)] = Field(default=9, description="Modbus address of the gripper")
    read_function: Literal[3, 4] = Field(
        default=4, description="Modbus function that reads the status; 3 in older manuals"
    )

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield when there is not one way to the gripper, or its speeds do not rise."""
        yield from super().mistakes(root)
        if (self.serial is None) == (self.host is None):
            key = "host" if self.host else "type"
            yield key, "a gripper is on one serial line or behind one host", "write `serial: ...` or `host: ...`"


class RobotiqGripper(RobotiqDriver):
    """A Robotiq 2F-85 or 2F-140 by Modbus, on a serial line, through a gateway that passes RTU frames on, or by Modbus TCP."""

    Options = _ModbusOptions
    options: _ModbusOptions
    packages: ClassVar[Mapping[str, str]] = {"pymodbus": "'pymodbus>=3.13,<4'", "serial": "pyserial"}

    def claimed(self) -> str:
        """Return where the gripper is; a serial line by its own name, whatever link leads there."""
        o = self.options
        if o.serial is not None:
            return f"the gripper on {os.path.realpath(o.serial)}"
        return f"the gripper at {o.host} port {o.port} unit {o.unit}"

    def _wire(self) -> GripperWire:
        return ModbusWire(self._client, self.options.unit, self.options.read_function)

    def _client(self) -> Client:
        o = self.options
        if o.serial is not None:
            return serial_client(o.serial, o.baudrate, o.timeout)
        return tcp_client(o.host or "", o.port, o.framing, o.timeout)
