"""A few questions to a controller by RTDE, with plain sockets and deadlines, and no client library; nothing moves by them.

Packages begin with their size, header included, in two bytes and their type in one, all big-endian; by the maker's guide to "Real-Time Data
Exchange", protocol version 2.
"""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Any

__all__ = ["Rtde"]

_PORT, _WITHIN = 30004, 2.0
#: rate of the packages of a reading, 1/s; every controller has it
_RATE = 125.0
_LONGEST = 8192
_TYPES = {"DOUBLE": "d", "UINT32": "I", "INT32": "i", "VECTOR6D": "6d"}


class Rtde:
    """A connection to a controller.

    Parameters
    ----------
    host
        Address of the controller.
    within
        Time for connecting, and for each answer, s.

    Raises
    ------
    OSError
        Nobody answers in time, or the answer is not from a controller.
    """

    def __init__(self, host: str, within: float = _WITHIN) -> None:
        self._within, self._rest = within, b""
        self._wire = socket.create_connection((host, _PORT), timeout=within)
        try:
            if self._ask("V", struct.pack(">H", 2)) != b"\x01":
                raise OSError("the controller does not take protocol version 2 of RTDE")
        except BaseException:
            self._wire.close()
            raise

    def __enter__(self) -> Rtde:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._wire.close()

    def version(self) -> tuple[int, ...]:
        """Return the version of the controller: major, minor, bugfix, build."""
        return tuple(_unpack(["UINT32"] * 4, self._ask("v", b"")))

    def read(self, names: Sequence[str]) -> list[Any]:
        """Return the present values of some outputs, vectors as tuples; raises OSError for one that the controller does not have."""
        types = (
            self._ask("O", struct.pack(">d", _RATE) + ",".join(names).encode())[1:]
            .decode("ascii", "replace")
            .split(",")
        )
        if not set(types) <= set(_TYPES):
            raise OSError(f"the controller does not have all of {', '.join(names)}")
        self._send("S", b"")
        try:
            return _unpack(types, self._await("U")[1:])
        finally:
            self._ask("P", b"")

    def claim(self, name: str) -> bytes | None:
        """Return what `write` needs to write a whole number to an input, which is this connection's until it is closed.

        None where another client writes it; raises OSError where the controller has no such input.
        """
        answer = self._ask("I", name.encode())
        if answer[1:] == b"IN_USE":
            return None
        if answer[1:] != b"INT32":
            raise OSError(f"{name} is not to be had")
        return answer[:1]

    def write(self, claimed: bytes, value: int) -> None:
        """Write a whole number to an input that was claimed."""
        self._send("U", claimed + struct.pack(">i", value))

    def _ask(self, kind: str, payload: bytes) -> bytes:
        self._send(kind, payload)
        return self._await(kind)

    def _send(self, kind: str, payload: bytes) -> None:
        self._wire.sendall(struct.pack(">HB", 3 + len(payload), ord(kind)) + payload)

    def _await(self, kind: str) -> bytes:
        """Return the next package of a kind, past others such as texts for a log."""
        due = time.monotonic() + self._within
        while time.monotonic() < due:
            found, payload = self._package()
            if found == ord(kind):
                return payload
        raise TimeoutError(f"no answer by RTDE within {self._within:g} s")

    def _package(self) -> tuple[int, bytes]:
        size, kind = struct.unpack(">HB", self._bytes(3))
        if not 3 <= size <= _LONGEST:
            raise OSError("the answer is from no controller, or from a broken one")
        return kind, self._bytes(size - 3)

    def _bytes(self, count: int) -> bytes:
        while len(self._rest) < count:
            data = self._wire.recv(4096)
            if not data:
                raise OSError("the controller closed the connection")
            self._rest += data
        found, self._rest = self._rest[:count], self._rest[count:]
        return found


def _unpack(types: Sequence[str], data: bytes) -> list[Any]:
    layouts = [">" + _TYPES[name] for name in types]
    sizes = [struct.calcsize(layout) for layout in layouts]
    if sum(sizes) != len(data):
        raise OSError("the controller's data are broken")
    found, start = [], 0
    for layout, size in zip(layouts, sizes, strict=True):
        values = struct.unpack(layout, data[start : start + size])
        found.append(values if len(values) > 1 else values[0])
        start += size
    return found
