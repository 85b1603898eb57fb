"""The way from a stand-in's answer to the client, on which an answer can be lost, late or broken."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from stretch_bt.hardware.emulators.faults import Fault, Faults

__all__ = ["LINE_FAULTS", "FaultyLine"]

A = TypeVar("A")

#: faults of a wire on which each question has an answer
LINE_FAULTS: dict[str, Fault] = {
    "drop": Fault("closes all connections and refuses new ones", state=True),
    "reset": Fault("breaks all connections once; new ones are taken"),
    "freeze": Fault("answers nothing, on connections that stay open"),
    "slow": Fault("answers after `delay` seconds", {"delay": 0.1}),
    "late": Fault("keeps an answer back until the next question, and sends it in place of that one's"),
    "corrupt": Fault("flips bits of the answer"),
    "truncate": Fault("sends the first half of the answer only"),
    "garbage": Fault("sends `bytes` bytes of noise in place of the answer", {"bytes": 64.0}),
}


class FaultyLine:
    """Passes answers on, as the active faults let it; one for each connection."""

    def __init__(self, faults: Faults, send: Callable[[bytes], None]) -> None:
        self._faults = faults
        self._send = send
        self._kept: bytes | None = None

    def answer(self, data: bytes) -> None:
        """Send an answer, or what a fault makes of it."""
        if self._faults.take("freeze") is not None:
            return
        slow = self._faults.take("slow")
        if slow is not None:
            time.sleep(slow["delay"])
        if self._faults.take("late") is not None:
            data, self._kept = self._kept or b"", data
        elif self._kept is not None:
            data, self._kept = self._kept + data, None
        if data:
            self._send(self._broken(data))

    def _broken(self, data: bytes) -> bytes:
        if self._faults.take("corrupt") is not None:
            middle = len(data) // 2
            data = data[:middle] + bytes([data[middle] ^ 0x5A]) + data[middle + 1 :]
        if self._faults.take("truncate") is not None:
            data = data[: len(data) // 2]
        garbage = self._faults.take("garbage")
        if garbage is not None:
            data = bytes((37 * k + 11) % 251 for k in range(int(garbage["bytes"])))
        return data
