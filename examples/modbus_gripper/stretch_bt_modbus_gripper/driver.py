"""The driver: the messages on the wire, and their meaning; one thread polls the gripper and sends commands between the polls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pymodbus import ModbusException
from pymodbus.client import ModbusTcpClient

from stretch_bt.devices import GripperDriver, Mistake, MotionState, Poll, PolledDriver, Reading, WireError, Within
from stretch_bt.units import Frequency, Length, Time
from stretch_bt_modbus_gripper import registers as r

_ENDS = {r.ARRIVED: MotionState.DONE, r.BLOCKED: MotionState.BLOCKED, r.HELD: MotionState.STOPPED}


class TwoJawWire:
    """The connection, which one thread uses; every failure is a WireError."""

    def __init__(self, host: str, port: int, timeout: float) -> None:
        self._client = ModbusTcpClient(host, port=port, timeout=timeout, retries=0)

    def connect(self) -> None:
        """Connect; moves nothing."""
        if not self._client.connect():
            raise WireError("nobody answers")

    def read(self) -> r.Status:
        """Return the status of the gripper."""
        opening, state = self._answered(lambda: self._client.read_holding_registers(r.OPENING, count=2, device_id=1))
        return r.Status(opening * r.COUNT, state)

    def go(self, opening: float, speed: float) -> None:
        """Send the fingers to an opening, m, at a speed, m/s."""
        self._write(r.TARGET, [round(opening / r.COUNT), max(round(speed / r.SPEED_COUNT), 1), r.GO])

    def hold(self) -> None:
        """Stop the fingers where they are."""
        self._write(r.COMMAND, [r.HOLD])

    def close(self) -> None:
        """Disconnect."""
        self._client.close()

    def _write(self, address: int, values: list[int]) -> None:
        self._answered(lambda: self._client.write_registers(address, values, device_id=1))

    @staticmethod
    def _answered(ask: Callable[[], Any]) -> list[int]:
        try:
            reply = ask()
        except (ModbusException, OSError) as error:
            raise WireError(str(error)) from error
        if reply.isError():
            raise WireError(f"it refused a request ({reply})")
        return list(reply.registers)


class TwoJawGripper(PolledDriver[TwoJawWire, r.Status], GripperDriver):
    """A gripper with two jaws by Modbus TCP."""

    @dataclass(frozen=True)
    class Options:
        """The options of a cell file."""

        host: str  # address of the gripper
        port: Annotated[int, Within(1, 65535)] = 502  # of that host
        stroke: Annotated[Length, Within(0.01, 0.5, "Length")] = 0.14  # greatest opening
        rate: Annotated[Frequency, Within(5, 200, "Frequency")] = 50.0  # of asking for the status
        timeout: Annotated[Time, Within(0.02, 2, "Time")] = 0.3  # of one exchange

        def mistakes(self, root: Path) -> Iterator[Mistake]:
            """Yield when there is no time for an exchange between two polls that are lost."""
            if self.timeout < 1 / self.rate:
                yield "timeout", f"an exchange has less time than a poll, {1 / self.rate:g} s", "write a longer timeout"

        def openings(self) -> tuple[float, float]:
            """Return the least and the greatest opening, m."""
            return 0.0, self.stroke

    options: Options

    def claimed(self) -> str:
        """Return which gripper it is: one program at a time commands it."""
        return f"the gripper at {self.options.host} port {self.options.port}"

    def wire(self) -> TwoJawWire:
        """Return the connection, which the thread opens and reads."""
        self.rate, self.deadline = self.options.rate, 4 * self.options.timeout
        return TwoJawWire(self.options.host, self.options.port, self.options.timeout)

    def move(self, opening: float, speed: float) -> Poll:
        """Begin to move the fingers."""
        begun = self.command(lambda wire: wire.go(opening, speed))

        def poll() -> MotionState:
            told = self.since(begun)
            return MotionState.MOVING if told is None else _ENDS.get(told.state, MotionState.MOVING)

        return poll

    def halt(self, wire: TwoJawWire) -> None:
        """Hold the fingers where they are."""
        wire.hold()

    def opening(self) -> Reading[float]:
        """Return the latest opening, m."""
        sample = self.latest()
        return sample.reading(sample.value.opening)
