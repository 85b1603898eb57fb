"""The server's side of Modbus: frames in, frames out. Nothing here knows what the registers mean."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

__all__ = ["Framing", "Refused", "Request", "RtuFraming", "TcpFraming", "answer", "crc16"]

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
_MOST = 260


class Refused(Exception):
    """A request that is answered by a Modbus exception; `code` is that of the exception."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(code)


class Registers(Protocol):
    """What the requests are about."""

    def read(self, function: int, start: int, count: int) -> list[int]:
        """Return registers; raises Refused."""
        ...

    def write(self, start: int, values: list[int]) -> None:
        """Take registers; raises Refused."""
        ...


def crc16(data: bytes) -> int:
    """Return the CRC of an RTU frame (polynomial 0xA001, from 0xFFFF), sent low byte first."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def answer(pdu: bytes, registers: Registers) -> bytes:
    """Return the answer to a request without its frame; anything that is none is answered by an exception."""
    function = pdu[0] if pdu else 0
    try:
        if function in (3, 4) and len(pdu) == 5:
            start, count = struct.unpack(">HH", pdu[1:])
            values = registers.read(function, start, count)
            return struct.pack(f">BB{len(values)}H", function, 2 * len(values), *values)
        if function == 16 and len(pdu) >= 6:
            start, count, size = struct.unpack(">HHB", pdu[1:6])
            if size != 2 * count or len(pdu) != 6 + size or count == 0:
                raise Refused(ILLEGAL_VALUE)
            registers.write(start, list(struct.unpack(f">{count}H", pdu[6:])))
            return pdu[:5]
        raise Refused(ILLEGAL_VALUE if function in (3, 4, 16) else ILLEGAL_FUNCTION)
    except Refused as refused:
        return bytes([function | 0x80, refused.code])


class Request(Protocol):
    """A request that came in a frame."""

    @property
    def unit(self) -> int:
        """Address of the device that is meant."""
        ...

    @property
    def pdu(self) -> bytes:
        """The request without its frame."""
        ...

    def frame(self, reply: bytes, *, unit: int | None = None, wrong: bool = False) -> bytes:
        """Return the frame of an answer; for another unit, or with a wrong check, where asked."""
        ...


class Framing(Protocol):
    """Cuts requests out of a stream of bytes; one for each connection."""

    def requests(self, data: bytes) -> Iterator[Request]:
        """Yield each request that is whole."""
        ...


@dataclass(frozen=True)
class RtuRequest:
    """A request with a CRC around it."""

    unit: int
    pdu: bytes

    def frame(self, reply: bytes, *, unit: int | None = None, wrong: bool = False) -> bytes:
        """Return the frame of an answer."""
        body = bytes([self.unit if unit is None else unit]) + reply
        return body + (crc16(body) ^ (0xFFFF if wrong else 0)).to_bytes(2, "little")


class RtuFraming:
    """Address, request and CRC; a stream that is out of step is thrown away, as silence between frames does on a line."""

    def __init__(self) -> None:
        self._rest = b""

    def requests(self, data: bytes) -> Iterator[RtuRequest]:
        """Yield what is whole."""
        self._rest += data
        while len(self._rest) >= 8:
            size = self._size()
            if size is not None and len(self._rest) < size:
                return
            if size is None or crc16(self._rest[: size - 2]) != int.from_bytes(self._rest[size - 2 : size], "little"):
                self._rest = b""
                return
            frame, self._rest = self._rest[:size], self._rest[size:]
            yield RtuRequest(frame[0], frame[1:-2])

    def _size(self) -> int | None:
        function = self._rest[1]
        if function in (1, 2, 3, 4, 5, 6):
            return 8
        return 9 + self._rest[6] if function in (15, 16) else None


@dataclass(frozen=True)
class TcpRequest:
    """A request with a header before it."""

    unit: int
    pdu: bytes
    transaction: int

    def frame(self, reply: bytes, *, unit: int | None = None, wrong: bool = False) -> bytes:
        """Return the frame of an answer."""
        transaction = self.transaction ^ (0x5A5A if wrong else 0)
        return struct.pack(">HHHB", transaction, 0, len(reply) + 1, self.unit if unit is None else unit) + reply


class TcpFraming:
    """Modbus TCP: a header with transaction, protocol, length and unit."""

    def __init__(self) -> None:
        self._rest = b""

    def requests(self, data: bytes) -> Iterator[TcpRequest]:
        """Yield what is whole; a header that is none throws the stream away."""
        self._rest += data
        while len(self._rest) >= 8:
            transaction, protocol, length, unit = struct.unpack(">HHHB", self._rest[:7])
            if protocol != 0 or not 2 <= length <= _MOST:
                self._rest = b""
                return
            if len(self._rest) < 6 + length:
                return
            pdu, self._rest = self._rest[7 : 6 + length], self._rest[6 + length :]
            yield TcpRequest(unit, pdu, transaction)
