"""The port through which faults are injected: one JSON object a line in, one a line out.

| line | answer |
|---|---|
| `{"do": "list"}` | `{"ok": true, "devices": {name: {"wires": {...}, "faults": {...}, "active": [...], "state": {...}}}}` |
| `{"do": "inject", "device": D, "fault": F, ...parameters}` | `{"ok": true}` |
| `{"do": "clear"}`, with `device` and `fault` or without | `{"ok": true}` |
| `{"do": "renew"}`: a new object in the place of the present one, which was pressed out of shape | `{"ok": true}` |

A mistake in a line is answered by `{"ok": false, "error": why}`. A connection whose first line is no JSON object
is closed, and so is one with a line of more than 4096 bytes: the rest is not read. A request of HTTP gets no answer.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Mapping
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.remote import RemoteStandIn
from stretch_bt.hardware.emulators.tcp_server import TcpServer, lines
from stretch_bt.source import did_you_mean

__all__ = ["ControlPort", "control"]

_LONGEST = 4096
_PATIENCE = 15.0  # s that an answer may take


class ControlPort:
    """Serves the control lines of some stand-ins.

    Parameters
    ----------
    address
        Host and port; port 0 takes a free one.
    stand_ins
        The stand-ins, by name.
    wires
        Where the wires of each are.
    renew
        Puts a new object in the place of the present one; raises InvalidInput where that cannot be.
    """

    def __init__(
        self,
        address: tuple[str, int],
        stand_ins: Mapping[str, StandIn | RemoteStandIn],
        wires: Mapping[str, Mapping[str, str]],
        renew: Callable[[], None],
    ) -> None:
        self._stand_ins, self._wires, self._renewed = stand_ins, wires, renew
        self._server = TcpServer(*address, self._serve)
        self.address = self._server.address

    def stop(self) -> None:
        """Close the port."""
        self._server.stop()

    def answer(self, line: bytes) -> dict[str, Any]:
        """Return the answer to a line, whatever it holds."""
        try:
            asked = json.loads(line)
            if not isinstance(asked, dict):
                raise InvalidInput('a line is one JSON object, such as {"do": "list"}')
            return {"ok": True, **self._do(asked)}
        except (ValueError, RecursionError, OverflowError, InvalidInput) as error:
            return {"ok": False, "error": str(error)}

    def _do(self, asked: dict[str, Any]) -> dict[str, Any]:
        verbs = {"list": self._list, "inject": self._inject, "clear": self._clear, "renew": self._renew}
        verb = asked.pop("do", None)
        if not isinstance(verb, str) or verb not in verbs:
            raise InvalidInput(f"there is nothing to do that is called {verb!r}; {did_you_mean(str(verb), verbs)}")
        return verbs[verb](asked)

    def _check_keys(self, asked: Mapping[str, Any], *known: str) -> None:
        for key in asked:
            if key not in known:
                raise InvalidInput(f"there is no key {key!r} here; {did_you_mean(key, known)}")

    def _list(self, asked: dict[str, Any]) -> dict[str, Any]:
        self._check_keys(asked)
        return {"devices": {name: self._described(name) for name in self._stand_ins}}

    def _described(self, name: str) -> dict[str, Any]:
        one = self._stand_ins[name]
        faults = {
            key: {"doc": f.doc, "parameters": dict(f.parameters), "choices": {k: list(v) for k, v in f.choices.items()}}
            for key, f in one.FAULTS.items()
        }
        return {"wires": self._wires[name], "faults": faults, "active": one.active(), "state": one.state()}

    def _inject(self, asked: dict[str, Any]) -> dict[str, Any]:
        device, fault = self._device(asked.pop("device", None)), asked.pop("fault", None)
        if not isinstance(fault, str):
            raise InvalidInput('name the fault: {"do": "inject", "device": ..., "fault": ...}')
        device.inject(fault, asked)
        return {}

    def _renew(self, asked: dict[str, Any]) -> dict[str, Any]:
        self._check_keys(asked)
        self._renewed()
        return {}

    def _clear(self, asked: dict[str, Any]) -> dict[str, Any]:
        self._check_keys(asked, "device", "fault")
        name, fault = asked.get("device"), asked.get("fault")
        if fault is not None and not isinstance(fault, str):
            raise InvalidInput(f"a fault has a name, not {fault!r}")
        for device in self._stand_ins.values() if name is None else [self._device(name)]:
            device.clear(fault)
        return {}

    def _device(self, name: object) -> StandIn | RemoteStandIn:
        if not isinstance(name, str) or name not in self._stand_ins:
            raise InvalidInput(f"there is no device {name!r} here; {did_you_mean(str(name), self._stand_ins)}")
        return self._stand_ins[name]

    def _serve(self, connection: socket.socket) -> None:
        for number, line in enumerate(lines(connection, _LONGEST + 1)):
            connection.sendall(json.dumps(self.answer(line)).encode() + b"\n")
            if number == 0 and not line.lstrip().startswith(b"{"):
                return


def control(address: tuple[str, int], asked: Mapping[str, Any]) -> dict[str, Any]:
    """Send one line to a control port, and return the answer.

    Raises
    ------
    OSError
        Nobody answers.
    InvalidInput
        The line was refused.
    """
    with socket.create_connection(address, timeout=_PATIENCE) as connection:
        connection.sendall(json.dumps(asked).encode() + b"\n")
        with connection.makefile("rb") as answers:
            line = answers.readline()
    if not line:
        raise OSError("the control port closed the connection without an answer")
    answer: dict[str, Any] = json.loads(line)
    if not answer.pop("ok"):
        raise InvalidInput(answer["error"])
    return answer
