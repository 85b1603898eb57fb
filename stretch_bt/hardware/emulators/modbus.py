"""The server's side of Modbus: frames in, frames out. Nothing here knows what the registers mean."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

__all__ = ["Framing", "ModbusRefused", "Request", "RtuFraming", "TcpFraming", "answer", "crc16"]

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
_MOST = 260
#: numbers of registers in one request, from the Modbus Application Protocol 1.1b3, sections 6.3, 6.12 and 6.17
_MOST_READ, _MOST_WRITTEN, _MOST_WRITTEN_AND_READ = 125, 123, 121
#: bytes of an RTU frame: the shortest one, and the number to wait for where the function does not say how long it is
_SHORTEST, _KNOWN_BY = 4, 8
#: functions whose frames say how many bytes follow, and which byte says so
_SIZE_AT = {15: 6, 16: 6, 23: 10}


class ModbusRefused(Exception):
    """A request that is answered by a Modbus exception; `code` is the code of the exception."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(code)


class Registers(Protocol):
    """What the requests are about."""

    def read(self, function: int, start: int, count: int) -> list[int]:
        """Return registers; raises ModbusRefused."""
        ...

    def write(self, start: int, values: list[int]) -> None:
        """Take registers; raises ModbusRefused."""
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
        if function not in _FUNCTIONS:
            raise ModbusRefused(ILLEGAL_FUNCTION)
        return bytes([function]) + _FUNCTIONS[function](pdu, registers)
    except ModbusRefused as refused:
        return bytes([function | 0x80, refused.code])


def _read(pdu: bytes, registers: Registers) -> bytes:
    start, count = _words(pdu[1:], 2)
    _check_count(count, _MOST_READ)
    return _counted(registers.read(pdu[0], start, count))


def _write_one(pdu: bytes, registers: Registers) -> bytes:
    start, value = _words(pdu[1:], 2)
    registers.write(start, [value])
    return pdu[1:]


def _write(pdu: bytes, registers: Registers) -> bytes:
    start, values = _block(pdu[1:], _MOST_WRITTEN)
    registers.write(start, values)
    return pdu[1:5]


def _read_after_write(pdu: bytes, registers: Registers) -> bytes:
    start, count = _words(pdu[1:5], 2)
    _check_count(count, _MOST_READ)
    where, values = _block(pdu[5:], _MOST_WRITTEN_AND_READ)
    registers.read(pdu[0], start, count)  # where that is refused, nothing is written
    registers.write(where, values)
    return _counted(registers.read(pdu[0], start, count))


_FUNCTIONS: dict[int, Callable[[bytes, Registers], bytes]] = {
    3: _read,
    4: _read,
    6: _write_one,
    16: _write,
    23: _read_after_write,
}


def _block(data: bytes, most: int) -> tuple[int, list[int]]:
    """Return where to write and what: address, number of registers, number of bytes, and the registers."""
    start, count = _words(data[:4], 2)
    _check_count(count, most)
    if data[4:5] != bytes([2 * count]):
        raise ModbusRefused(ILLEGAL_VALUE)
    return start, list(_words(data[5:], count))


def _words(data: bytes, count: int) -> tuple[int, ...]:
    """Return that many words of 16 bits; raises ModbusRefused where there are more or fewer."""
    if len(data) != 2 * count:
        raise ModbusRefused(ILLEGAL_VALUE)
    return struct.unpack(f">{count}H", data)


def _check_count(count: int, most: int) -> None:
    if not 1 <= count <= most:
        raise ModbusRefused(ILLEGAL_VALUE)


def _counted(values: list[int]) -> bytes:
    return struct.pack(f">B{len(values)}H", 2 * len(values), *values)


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
        while len(self._rest) >= _SHORTEST:
            size = self._size()
            if len(self._rest) < size:
                return
            if crc16(self._rest[: size - 2]) != int.from_bytes(self._rest[size - 2 : size], "little"):
                if len(self._rest) >= _KNOWN_BY:
                    self._rest = b""
                return
            frame, self._rest = self._rest[:size], self._rest[size:]
            yield RtuRequest(frame[0], frame[1:-2])

    def _size(self) -> int:
        """Return how long the first frame is; of a function that is not known it is all that came."""
        function = self._rest[1]
        if function in (1, 2, 3, 4, 5, 6):
            return 8
        where = _SIZE_AT.get(function)
        if where is None:
            return len(self._rest)
        return where + 3 + self._rest[where] if len(self._rest) > where else where + 3


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
        """Yield the complete requests; an invalid header throws the stream away."""
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
