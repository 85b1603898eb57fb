"""A stand-in for a Robotiq gripper on Modbus."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping
from typing import ClassVar

from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.gripper_model import GRIPPER_FAULTS, GripperModel
from stretch_bt.hardware.emulators.gripper_stand_in import GripperStandIn
from stretch_bt.hardware.emulators.line import LINE_FAULTS, FaultyLine
from stretch_bt.hardware.emulators.modbus import (
    ILLEGAL_ADDRESS,
    Framing,
    ModbusRefused,
    Request,
    RtuFraming,
    TcpFraming,
    answer,
)
from stretch_bt.hardware.emulators.serial_line import SerialLine
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer, unless_web
from stretch_bt.hardware.robotiq.registers import COUNT, READ_FROM, WRITE_TO, Command

__all__ = ["RobotiqStandIn"]

_UNIT = 9
_READ_INPUTS = 4
_CRC = Fault("sends a wrong CRC; on Modbus TCP, which has none, a wrong transaction number")
_OTHER = Fault("answers for the unit `unit`", {"unit": 7.0})
_REFUSE = Fault("answers with the Modbus exception `code`", {"code": 4.0})


class _Registers:
    """The two blocks of registers of the gripper: its status, and its last command, which can be read back."""

    def __init__(self, model: GripperModel) -> None:
        self._model = model

    def read(self, function: int, start: int, count: int) -> list[int]:
        """Return registers; written registers are holding registers, not inputs, and function 4 does not read them."""
        if _within(READ_FROM, start, count):
            return _part(self._model.read().encode(), start - READ_FROM, count)
        if function != _READ_INPUTS and _within(WRITE_TO, start, count):
            return _part(self._model.command.encode(), start - WRITE_TO, count)
        raise ModbusRefused(ILLEGAL_ADDRESS)

    def write(self, start: int, values: list[int]) -> None:
        """Give the gripper a command; the registers that are not written stay as they are."""
        if not _within(WRITE_TO, start, len(values)):
            raise ModbusRefused(ILLEGAL_ADDRESS)
        told, first = self._model.command.encode(), start - WRITE_TO
        told[first : first + len(values)] = values
        self._model.write(Command.decode(told))


def _within(block: int, start: int, count: int) -> bool:
    return block <= start and start + count <= block + COUNT


def _part(registers: list[int], first: int, count: int) -> list[int]:
    return registers[first : first + count]


class RobotiqStandIn(GripperStandIn):
    """A 2F-140 that answers RTU frames on a serial line and on a TCP port, and Modbus TCP on another."""

    PORTS: ClassVar[Mapping[str, int]] = {"rtu": 54321, "tcp": 1502}
    FAULTS: ClassVar[Mapping[str, Fault]] = {
        **LINE_FAULTS,
        "crc": _CRC,
        "unit": _OTHER,
        "refuse": _REFUSE,
        **GRIPPER_FAULTS,
    }

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        super().__init__(host, stage, ports)
        self._registers = _Registers(self.model)
        self._line: SerialLine | None = None

    def start(self) -> dict[str, str]:
        """Open the ports and the serial line."""
        framings: dict[str, Callable[[], Framing]] = {"rtu": RtuFraming, "tcp": TcpFraming}
        places = {}
        try:
            for wire, port in self.ports.items():
                make = framings[wire]
                server = TcpServer(self.host, port, lambda c, make=make: self._serve(c, make()), self.refuses)  # type: ignore[misc]
                self._servers.append(server)
                places[wire] = f"{server.address[0]}:{server.address[1]}"
        except BaseException:
            self.stop()
            raise
        framing = RtuFraming()
        self._line = SerialLine(lambda data, line: self._take(data, framing, line), self.faults)
        return {**places, "serial": self._line.path}

    def stop(self) -> None:
        """Close the ports and the serial line."""
        super().stop()
        if self._line is not None:
            self._line.stop()
            self._line = None

    def _serve(self, connection: socket.socket, framing: Framing) -> None:
        line = FaultyLine(self.faults, connection.sendall)
        for data in unless_web(connection):
            self._take(data, framing, line)

    def _take(self, data: bytes, framing: Framing, line: FaultyLine) -> None:
        for request in framing.requests(data):
            if request.unit == _UNIT:  # else on a bus another device is meant
                line.answer(self._reply(request))

    def _reply(self, request: Request) -> bytes:
        with self.lock:
            reply = answer(request.pdu, self._registers)
        refuse, other = self.faults.take("refuse"), self.faults.take("unit")
        if refuse is not None:
            reply = bytes([request.pdu[0] | 0x80, int(refuse["code"]) & 0xFF])
        unit = int(other["unit"]) & 0xFF if other is not None else None
        return request.frame(reply, unit=unit, wrong=self.faults.take("crc") is not None)
