"""A stand-in for the socket of Robotiq's URCap on a robot's controller.

It confirms what is set at once, and shows what the gripper makes of it only once it has asked the gripper again.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.gripper_model import GRIPPER_FAULTS
from stretch_bt.hardware.emulators.gripper_stand_in import GripperStandIn
from stretch_bt.hardware.emulators.line import LINE_FAULTS, FaultyLine
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer, batches
from stretch_bt.hardware.robotiq.registers import Command, Status

__all__ = ["CYCLE", "QUESTIONS", "UrcapStandIn", "parse_line"]

#: how long it shows what it asked the gripper last, s, and for how many questions at most, because a clock may stand
CYCLE, QUESTIONS = 0.020, 10
_PAIR = re.compile(r"([A-Z]{3}) (\d{1,3})")
_LONGEST = 1024
_UNKNOWN = "?\n"
_FLAGS = ("activate", "go", "release", "release_opens")
#: variables that can be set, with the field of the command, none where there is none, and its greatest value; clients write one both ways
_SET = {
    "ACT": ("activate", 1),
    "GTO": ("go", 1),
    "ATR": ("release", 1),
    "ARD": ("release_opens", 1),
    "ADR": ("release_opens", 1),
    "POS": ("position", 255),
    "SPE": ("speed", 255),
    "FOR": ("force", 255),
    "SID": (None, 247),
}


def parse_line(line: str) -> tuple[str, dict[str, int]] | None:
    """Return `("GET", {name: 0})` or `("SET", values)` for a line of the protocol, or None for anything else."""
    verb, _, rest = line.strip().partition(" ")
    if verb == "GET" and re.fullmatch(r"[A-Z]{3}", rest):
        return "GET", {rest: 0}
    pairs = _PAIR.findall(rest)
    if verb != "SET" or not pairs or " ".join(f"{n} {v}" for n, v in pairs) != rest:
        return None
    values = {name: int(value) for name, value in pairs}
    known = all(name in _SET and value <= _SET[name][1] for name, value in values.items())
    return ("SET", values) if known else None


class UrcapStandIn(GripperStandIn):
    """A 2F-140 at the wrist of a robot that is not there."""

    PORTS: ClassVar[Mapping[str, int]] = {"urcap": 63352}
    FAULTS: ClassVar[Mapping[str, Fault]] = {
        **LINE_FAULTS,
        "nothing": Fault("answers every GET with `?`, as after an emergency stop"),
        **GRIPPER_FAULTS,
    }

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        super().__init__(host, stage, ports)
        self._last = Command(activate=False)
        self._shown: Status | None = None
        self._shown_at, self._questions = 0.0, 0

    def start(self) -> dict[str, str]:
        """Open the port."""
        server = TcpServer(self.host, self.ports["urcap"], self._serve, self.refuses)
        self._servers.append(server)
        return {"urcap": f"{server.address[0]}:{server.address[1]}"}

    def _serve(self, connection: socket.socket) -> None:
        line = FaultyLine(self.faults, connection.sendall)
        self._shown = None
        for asked in batches(connection, _LONGEST):
            line.answer("".join(self._reply(text.decode("ascii", "replace")) for text in asked).encode())

    def _reply(self, text: str) -> str:
        """Return the answer to a line: a value with an end of line, a bare `ack`, or a question mark for what it does not know."""
        parsed = parse_line(text)
        if parsed is None:
            return _UNKNOWN
        verb, values = parsed
        with self.lock:
            return self._get(next(iter(values))) if verb == "GET" else self._set(values)

    def _get(self, name: str) -> str:
        status = self._status()
        value = {
            "ACT": int(status.activated),
            "GTO": int(status.going),
            "ATR": int(self._last.release),
            "ARD": int(self._last.release_opens),
            "ADR": int(self._last.release_opens),
            "FOR": self._last.force,
            "SPE": self._last.speed,
            "POS": status.position,
            "STA": int(status.stage),
            "PRE": status.echo,
            "OBJ": int(status.found),
            "FLT": status.fault,
            "SID": 9,
        }.get(name)
        if value is None:
            return _UNKNOWN
        return f"{name} ?\n" if self.faults.take("nothing") is not None else f"{name} {value}\n"

    def _status(self) -> Status:
        """Return what it asked the gripper last, and ask again where that is old."""
        now = self.stage.now()
        self._questions += 1
        if self._shown is None or now - self._shown_at >= CYCLE or self._questions > QUESTIONS:
            self._shown, self._shown_at, self._questions = self.model.read(), now, 1
        return self._shown

    def _set(self, values: Mapping[str, int]) -> str:
        fields = {_SET[name][0]: value for name, value in values.items() if _SET[name][0] is not None}
        now = self.model.read()
        command = replace(self._last, activate=now.activated, go=now.going and now.ready)
        flags = {k: bool(v) if k in _FLAGS else v for k, v in fields.items()}
        self._last = replace(command, **flags)  # type: ignore[arg-type]
        self.model.write(self._last)
        return "ack"
