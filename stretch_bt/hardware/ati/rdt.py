"""Raw Data Transfer, the stream of ATI's network sensors over UDP: 8 bytes ask, 36 bytes answer, big-endian."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

from stretch_bt.errors import InvalidInput

__all__ = ["HEADER", "PORT", "Ask", "Record", "parse_request", "request", "status_text"]

PORT, HEADER = 49152, 0x1234
_REQUEST = struct.Struct(">HHI")
_RECORD = struct.Struct(">III6i")

#: bits of the status word, from the manual of the Axia; the number of a bit is always reported with its name
_BITS = {
    0: "internal temperature out of range",
    1: "supply voltage out of range",
    2: "broken strain gauge",
    3: "busy",
    5: "hardware error",
    27: "strain gauge out of range",
    28: "simulated error",
    29: "calibration does not match its checksum",
    30: "force or torque out of range",
    31: "error",
}
_UNKNOWN = "not in the manual of the Axia"
#: bits that only the manual of another sensor has, which speaks RDT too
_ELSEWHERE = {16: f"{_UNKNOWN}; of a Net F/T: a monitor condition that is latched"}


class Ask(IntEnum):
    """Commands of a request."""

    STOP = 0
    STREAM = 2
    BUFFERED = 3
    BIAS = 0x42


@dataclass(frozen=True, slots=True)
class Record:
    """One measurement: its number in the stream, the number of the sensor's own cycle, a status word, six counts."""

    number: int
    cycle: int
    status: int
    counts: tuple[int, int, int, int, int, int]

    def encode(self) -> bytes:
        """Return the 36 bytes."""
        return _RECORD.pack(self.number, self.cycle, self.status, *self.counts)

    @classmethod
    def decode(cls, data: bytes) -> Record:
        """Return the record in 36 bytes; raises InvalidInput for any other length."""
        if len(data) != _RECORD.size:
            raise InvalidInput(f"a record has {_RECORD.size} bytes, not {len(data)}")
        number, cycle, status, *counts = _RECORD.unpack(data)
        fx, fy, fz, tx, ty, tz = counts
        return cls(number, cycle, status, (fx, fy, fz, tx, ty, tz))


def request(ask: Ask, count: int = 0) -> bytes:
    """Return the 8 bytes that ask for `count` records; 0 is without end."""
    return _REQUEST.pack(HEADER, ask, count)


def parse_request(data: bytes) -> tuple[int, int] | None:
    """Return command and count of a request, or None when it is none."""
    if len(data) != _REQUEST.size:
        return None
    header, command, count = _REQUEST.unpack(data)
    return (command, count) if header == HEADER else None


def status_text(status: int) -> str:
    """Return what a status word says, bit by bit."""
    names = {**_BITS, **_ELSEWHERE}
    bits = [bit for bit in range(31) if status >> bit & 1] or [31]
    return ", ".join(f"{names.get(bit, _UNKNOWN)} (bit {bit})" for bit in bits)
