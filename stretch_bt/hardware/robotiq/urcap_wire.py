"""A gripper by the socket of Robotiq's URCap on the robot's controller: lines of text, `GET POS` and `SET POS 100 GTO 1`."""

from __future__ import annotations

import re
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TypeVar

from stretch_bt.hardware.robotiq.registers import ActivationStage, ObjectStatus, Status
from stretch_bt.hardware.wire_thread import WireClosed, WireError

__all__ = ["UrcapWire", "parse_value"]

R = TypeVar("R")
_TRIES = 2
_VALUE = re.compile(rb"([A-Z]{3}) ?(\d{1,3}|\?)")
_LONGEST = 256
_ACK = b"ack"
#: a command is confirmed before the gripper has it: what says that it has (GTO, PRE) comes before what it says of it (FLT, OBJ, POS)
_ASKED = ("ACT", "STA", "GTO", "PRE", "FLT", "OBJ", "POS")
_RANGES = {"ACT": 1, "GTO": 1, "STA": 3, "OBJ": 3}


def parse_value(line: bytes, name: str) -> int:
    """Return the value in the answer to `GET NAME`, such as `POS 13`.

    Raises
    ------
    WireError
        It answers something else, holds no value, or one out of range.
    """
    match = _VALUE.fullmatch(line.strip())
    if match is None or match[1] != name.encode():
        raise WireError(f"it answered {_shown(line)} to GET {name}")
    if match[2] == b"?":
        raise WireError(
            f"it has no value for {name}: is the robot stopped by its emergency stop, or the gripper without power?"
        )
    value = int(match[2])
    if value > _RANGES.get(name, 255):
        raise WireError(f"{name} is {value}, which it cannot be")
    return value


class UrcapWire:
    """One line at a time, each answered by one line, or by `ack`, which has no end of line.

    Lines carry no number: after an answer that is missing or broken the connection is closed, so that a late one is never
    taken for the answer to the next question, and the line is sent once more on a new one.
    """

    exchanges = len(_ASKED)

    def __init__(self, host: str, port: int, timeout: float) -> None:
        self._address = (host, port)
        self._timeout = timeout
        self._socket: socket.socket | None = None
        self._rest = b""

    def connect(self) -> None:
        """Connect; raises OSError."""
        if self._socket is None:
            self._socket = socket.create_connection(self._address, timeout=self._timeout)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._rest = b""

    def close(self) -> None:
        """Disconnect."""
        connection, self._socket = self._socket, None
        if connection is not None:
            with suppress(OSError):
                connection.close()

    def read(self) -> Status:
        """Ask for the gripper's status, one variable after the other."""
        value = {name: self._ask(f"GET {name}", partial(parse_value, name=name)) for name in _ASKED}
        return Status(
            activated=bool(value["ACT"]),
            going=bool(value["GTO"]),
            stage=ActivationStage(value["STA"]),
            found=ObjectStatus(value["OBJ"]),
            fault=value["FLT"] & 0x0F,
            echo=value["PRE"],
            position=value["POS"],
        )

    def go(self, position: int, speed: int, force: int) -> None:
        """Send the fingers to a count."""
        self._set(f"POS {position} SPE {speed} FOR {force} GTO 1")

    def hold(self, status: Status) -> None:
        """End a motion where the fingers are."""
        self._set("GTO 0")

    def reset(self) -> None:
        """Clear faults and activation, and an automatic release, which would begin anew with the next activation."""
        for variable in ("GTO", "ACT", "ATR"):
            self._set(f"{variable} 0")

    def activate(self) -> None:
        """Begin the activation."""
        self._set("ACT 1")

    def _set(self, what: str) -> None:
        line = f"SET {what}"

        def check(answer: bytes) -> None:
            if answer != _ACK:
                raise WireError(f"it answered {_shown(answer)} to {line}")

        self._ask(line, check)

    def _ask(self, line: str, read: Callable[[bytes], R]) -> R:
        """Send a line and return what `read` makes of the next one that comes."""
        for left in reversed(range(_TRIES)):
            try:
                return read(self._exchange(line))
            except (ConnectionError, WireClosed) as error:
                self.close()
                raise WireClosed(f"the other side closed the connection ({error})") from error
            except OSError as error:
                self.close()
                if not left:
                    late = isinstance(error, TimeoutError)
                    raise WireError("no answer within the time of an exchange" if late else str(error)) from error
        raise AssertionError("not reached")

    def _exchange(self, line: str) -> bytes:
        self.connect()
        assert self._socket is not None
        if self._rest.strip():
            raise WireError(f"it said {_shown(self._rest)} without being asked")
        deadline = time.monotonic() + self._timeout
        self._socket.settimeout(self._timeout)
        self._socket.sendall(line.encode() + b"\n")
        while (answer := self._answer()) is None:
            if len(self._rest) > _LONGEST:
                raise WireError(f"it sent {len(self._rest)} bytes without the end of a line")
            self._socket.settimeout(max(deadline - time.monotonic(), 1e-3))
            data = self._socket.recv(_LONGEST)
            if not data:
                raise WireClosed("end of the stream")
            self._rest += data
        return answer

    def _answer(self) -> bytes | None:
        """Return the answer in what came, or None before it is complete; an end of line after the answer before is left out."""
        self._rest = self._rest.lstrip()
        if self._rest.startswith(_ACK):
            self._rest = self._rest.removeprefix(_ACK)
            return _ACK
        answer, end, rest = self._rest.partition(b"\n")
        if not end:
            return None
        self._rest = rest
        return answer


def _shown(data: bytes) -> str:
    """Return what came as text of at most 40 characters."""
    return repr(data[:40].decode("ascii", "backslashreplace"))
