"""Packages of RTDE, as a controller takes and sends them.

All numbers are big-endian; a package begins with its size, header included, in two bytes, and its type in one. By the maker's guide to
"Real-Time Data Exchange".
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Any

__all__ = [
    "LONGEST",
    "TYPES",
    "Packages",
    "Unpackable",
    "Value",
    "flat",
    "layout",
    "pack",
    "package",
    "size_of",
    "text_of",
    "unpack",
]

Value = Any

#: a client that announces a longer package is not followed; the two letters with which a request of HTTP begins would be a longer one
LONGEST = 1 << 14
_HEADER = 3
_TEXT = 200

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
    return struct.calcsize(layout(types))


def unpack(types: Sequence[str], data: bytes) -> list[Value]:
    """Return the values of a recipe, vectors as tuples; raises Unpackable when the number of bytes does not fit the types."""
    if len(data) != size_of(types):
        raise Unpackable(f"{len(data)} bytes, expected {size_of(types)} for {', '.join(types)}")
    numbers = iter(struct.unpack(layout(types), data))
    counts = [len(struct.unpack(">" + TYPES[t], bytes(struct.calcsize(">" + TYPES[t])))) for t in types]
    return [next(numbers) if n == 1 else tuple(next(numbers) for _ in range(n)) for n in counts]


def pack(types: Sequence[str], values: Sequence[Value]) -> bytes:
    """Return the bytes of values."""
    return struct.pack(layout(types), *flat(values))


def flat(values: Sequence[Value]) -> list[Any]:
    """Return the numbers of values one after the other, also the numbers of vectors."""
    return [v for value in values for v in (value if isinstance(value, tuple | list) else (value,))]


def text_of(payload: bytes, protocol: int) -> str:
    """Return the text of a client's message; of the second protocol it has its length before it."""
    text = payload[1 : 1 + payload[0]] if protocol > 1 and payload else payload[1:]
    return text.decode("utf-8", "replace")[:_TEXT]


def layout(types: Sequence[str]) -> str:
    """Return the format of values of these types, for `struct`."""
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
