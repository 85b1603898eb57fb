"""What a stand-in for a camera sends: a description of itself, then frames; made for this, no camera speaks it.

A packet is a header of 16 bytes, big-endian (`SBD1`, kind, three zeros, length of the body, its CRC-32), and a body: kind 1 describes the
camera in JSON, kind 2 is a frame: its number (u64), its time (f64, s), and its pixels (u16, little-endian, by rows).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from stretch_bt.errors import InvalidInput

__all__ = ["PORT", "CameraDescription", "Packets", "SentFrame"]

PORT = 29960
_MAGIC = b"SBD1"
_HEADER = struct.Struct(">4sB3xII")
_FRAME = struct.Struct(">Qd")
_DESCRIBED, _PICTURE = 1, 2
_LONGEST = _FRAME.size + 2 * 4096 * 4096
_LONGEST_TEXT = 4096

_Side = Annotated[int, Field(ge=1, le=4096)]
_Focal = Annotated[FiniteFloat, Field(gt=0, le=1e5)]


class CameraDescription(BaseModel):
    """What the camera reports of itself: `unit` in m, `rate` in Hz, the pinhole in pixels, inverse Brown-Conrady coefficients."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    serial: str = Field(max_length=64)
    width: _Side
    height: _Side
    rate: Annotated[int, Field(ge=1, le=1000)]
    unit: Annotated[FiniteFloat, Field(ge=1e-7, le=1e-2)]
    fx: _Focal
    fy: _Focal
    cx: FiniteFloat
    cy: FiniteFloat
    distortion: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] = (0.0,) * 5

    def encode(self) -> bytes:
        """Return the packet."""
        return _packet(_DESCRIBED, self.model_dump_json().encode())


@dataclass(frozen=True, slots=True)
class SentFrame:
    """A frame: its number, its time, s, and its pixels as they are sent."""

    number: int
    time: float
    pixels: bytes

    def encode(self) -> bytes:
        """Return the packet."""
        return _packet(_PICTURE, _FRAME.pack(self.number, self.time) + self.pixels)


class Packets:
    """Cuts what comes into packets; those whose checksum is wrong are counted in `broken` and left out."""

    def __init__(self) -> None:
        self.broken = 0
        self._rest = bytearray()

    def feed(self, data: bytes) -> Iterator[CameraDescription | SentFrame]:
        """Yield the packets that are complete now; raises InvalidInput for what is none, after which nothing more can be read."""
        self._rest += data
        while (packet := self._cut()) is not None:
            kind, crc, body = packet
            if zlib.crc32(body) != crc:
                self.broken += 1
            else:
                yield _decode(kind, body)

    def _cut(self) -> tuple[int, int, bytes] | None:
        if len(self._rest) < _HEADER.size:
            return None
        magic, kind, length, crc = _HEADER.unpack_from(self._rest)
        most = {_DESCRIBED: _LONGEST_TEXT, _PICTURE: _LONGEST}.get(kind, -1)
        if magic != _MAGIC or length > most:
            raise InvalidInput(f"no packet of a stand-in: {bytes(self._rest[:8]).hex(' ')} ...")
        end = _HEADER.size + length
        if len(self._rest) < end:
            return None
        body = bytes(self._rest[_HEADER.size : end])
        del self._rest[:end]
        return kind, crc, body


def _packet(kind: int, body: bytes) -> bytes:
    return _HEADER.pack(_MAGIC, kind, len(body), zlib.crc32(body)) + body


def _decode(kind: int, body: bytes) -> CameraDescription | SentFrame:
    if kind == _DESCRIBED:
        try:
            return CameraDescription.model_validate_json(body)
        except ValidationError as error:
            raise InvalidInput(f"no description of a camera: {error.errors()[0]['msg']}") from error
    if len(body) < _FRAME.size:
        raise InvalidInput(f"a frame of {len(body)} bytes")
    number, time = _FRAME.unpack_from(body)
    if not abs(time) < 1e12:  # nor NaN
        raise InvalidInput(f"a frame of the time {time} s")
    return SentFrame(number, time, body[_FRAME.size :])
