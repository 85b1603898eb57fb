"""Packages of RTDE, protocol version 2, as a controller takes and sends them.

All numbers are big-endian; a package begins with its size, header included, in two bytes, and its type in one. By the maker's guide to
"Real-Time Data Exchange".
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Any

__all__ = ["LONGEST", "TYPES", "Packages", "Unpackable", "Value", "pack", "package", "size_of", "unpack"]

Value = Any

#: packages of a controller are no longer; a client that announces a longer one is not followed
LONGEST = 8192
_HEADER = 3

TYPES: dict[str, str] = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}


class Unpackable(ValueError):
    """Bytes that are no package, or not one of the kind expected."""


def package(kind: str, payload: bytes) -> bytes:
    """Return a package of a kind, a letter."""
    return struct.pack(">HB", _HEADER + len(payload), ord(kind)) + payload


def size_of(types: Sequence[str]) -> int:
    """Return how many bytes values of these types take."""
    return struct.calcsize(_layout(types))


def unpack(types: Sequence[str], data: bytes) -> list[Value]:
    """Return the values of a recipe, vectors as tuples; raises Unpackable when the bytes are not those of the types."""
    if len(data) != size_of(types):
        raise Unpackable(f"{len(data)} bytes, expected {size_of(types)} for {', '.join(types)}")
    flat = iter(struct.unpack(_layout(types), data))
    counts = [len(struct.unpack(">" + TYPES[t], bytes(struct.calcsize(">" + TYPES[t])))) for t in types]
    return [next(flat) if n == 1 else tuple(next(flat) for _ in range(n)) for n in counts]


def pack(types: Sequence[str], values: Sequence[Value]) -> bytes:
    """Return the bytes of values."""
    flat = [v for value in values for v in (value if isinstance(value, tuple | list) else (value,))]
    return struct.pack(_layout(types), *flat)


def _layout(types: Sequence[str]) -> str:
    return ">" + "".join(TYPES[t] for t in types)


class Packages:
    """Cuts what comes over a connection into packages."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[tuple[str, bytes]]:
        """Yield (kind, payload) of the packages that are whole now; raises Unpackable for a size that none has."""
        self._rest += data
        while len(self._rest) >= _HEADER:
            size, kind = struct.unpack_from(">HB", self._rest)
            if not _HEADER <= size <= LONGEST:
                raise Unpackable(f"a package of {size} bytes")
            if len(self._rest) < size:
                return
            payload, self._rest = self._rest[_HEADER:size], self._rest[size:]
            yield chr(kind), payload
