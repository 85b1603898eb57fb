"""What an ATI sensor answers besides its stream: commands over TCP, and a page that says how it is set.

Both as in the manual of the Net F/T (9620-05-Net FT, sections on the TCP interface and on system settings by XML).
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stretch_bt.hardware.ati.rdt import HEADER
from stretch_bt.hardware.emulators.tcp_server import received

__all__ = ["COMMANDS", "PAGE", "AtiSensor", "answer", "serve_commands", "serve_page"]

#: ports of the sensor; its page is on 80, which not every user can open here
COMMANDS, PAGE = 49151, 49180
_COMMAND = struct.Struct(">B17xH")
_FORCES = struct.Struct(">2H6h")
_CALIBRATION = struct.Struct(">H2B2I6H")
_READ, _CALIBRATED = 0, 1
_BIAS = 1
#: units by their numbers in the manual: newton, and newton metre
_NEWTON, _NEWTON_METRE = 2, 3
#: counts that one of 16 bits stands for, so that 500 N and 20 Nm fill them
_SCALES = np.array([15260] * 3 + [611] * 3)
_LEAST, _MOST = -(1 << 15), (1 << 15) - 1
_LONGEST = 8192


class AtiSensor(Protocol):
    """What is asked."""

    #: counts a newton and a newton metre
    per_unit: tuple[int, int]
    settings: Mapping[str, str]

    def counts(self) -> NDArray[np.float64]:
        """Return the six counts of now, (6,), since the last bias."""
        ...

    def bias(self) -> None:
        """Take what is felt now as zero."""
        ...

    def status(self) -> int:
        """Return the status word."""
        ...

    def silent(self) -> bool:
        """Whether nothing is answered."""
        ...


def answer(command: bytes, sensor: AtiSensor) -> bytes | None:
    """Return the answer to the 20 bytes of a command; none to one that there is not."""
    number, system = _COMMAND.unpack(command)
    if number == _CALIBRATED:
        return _CALIBRATION.pack(HEADER, _NEWTON, _NEWTON_METRE, *sensor.per_unit, *_SCALES.tolist())
    if number != _READ:
        return None
    if system & _BIAS:
        sensor.bias()
    scaled = np.clip(np.round(sensor.counts() / _SCALES), _LEAST, _MOST).astype(int).tolist()
    return _FORCES.pack(HEADER, sensor.status() >> 16, *scaled)


def serve_commands(connection: socket.socket, sensor: AtiSensor) -> None:
    """Answer commands until the other side ends the connection, or begins with a letter, as requests of HTTP do and no command."""
    rest, first = b"", True
    for data in received(connection):
        rest += data
        if first and data[:1].isalpha():
            return
        first = False
        while len(rest) >= _COMMAND.size:
            command, rest = rest[: _COMMAND.size], rest[_COMMAND.size :]
            reply = None if sensor.silent() else answer(command, sensor)
            if reply is not None:
                connection.sendall(reply)


def serve_page(connection: socket.socket, sensor: AtiSensor) -> None:
    """Answer one request for a page."""
    asked = b""
    for data in received(connection):
        asked += data
        if b"\r\n\r\n" in asked or len(asked) > _LONGEST:
            break
    if not sensor.silent():
        connection.sendall(_page(asked.decode("latin-1"), sensor))


def _page(asked: str, sensor: AtiSensor) -> bytes:
    method, _, rest = asked.partition(" ")
    path = rest.partition(" ")[0].partition("?")[0]
    if method != "GET" or path != "/netftapi2.xml":
        return b"HTTP/1.0 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
    lines = (f"<{name}>{value}</{name}>" for name, value in _settings(sensor).items())
    body = "\n".join(['<?xml version="1.0"?>', "<netft>", *lines, "</netft>", ""]).encode()
    head = f"HTTP/1.0 200 OK\r\nContent-Type: text/xml\r\nContent-Length: {len(body)}\r\nConnection: close\r\n\r\n"
    return head.encode() + body


def _settings(sensor: AtiSensor) -> dict[str, str]:
    """Return the elements of the page; counts that are felt now among them."""
    newton, newton_metre = sensor.per_unit
    return {
        "runstat": f"0x{sensor.status():08x}",
        "runft": ";".join(str(round(count)) for count in sensor.counts().tolist()),
        "scfgfu": "N",
        "scfgtu": "Nm",
        "cfgcpf": str(newton),
        "cfgcpt": str(newton_metre),
        **sensor.settings,
    }
