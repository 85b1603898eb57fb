"""The side of RTDE that the controller has: recipes, claims on inputs, and packages at a rate."""

from __future__ import annotations

import select
import socket
import struct
from collections.abc import Callable
from contextlib import suppress

from stretch_bt.hardware.emulators.faults import Fault, Faults
from stretch_bt.hardware.emulators.tcp_server import TcpServer, deafen, received, sever
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.fields import INPUT_FIELDS, OUTPUT_FIELDS, found
from stretch_bt.hardware.emulators.ur.rtde_session import RtdeSession
from stretch_bt.hardware.emulators.ur.variables import OUTPUTS
from stretch_bt.hardware.emulators.ur.wire import Packages, Unpackable, package, size_of, text_of, unpack

__all__ = ["STREAM_FAULTS", "RtdeServer"]

#: versions of the protocol; the first has no numbers of output recipes, and one rate
_PROTOCOLS = (1, 2)
#: cycles from one package to the next at most
_SELDOM = 1e9
_FIRST_RATE = 125.0
_NOT_FOUND, _IN_USE = "NOT_FOUND", "IN_USE"

#: which connections a fault meets: of RTDE that which only reads, or that which controls; and which way
_RTDE = {"connection": ("rtde", "receive", "control")}
_ANY = {"connection": ("all", "rtde", "receive", "control", "dashboard", "script")}
_WAY = {"direction": ("both", "out", "in")}

STREAM_FAULTS: dict[str, Fault] = {
    "drop": Fault("closes all connections and refuses new ones", state=True),
    "reset": Fault("resets connections once; new ones are taken", state=True, choices=_ANY),
    "close": Fault(
        "closes connections once; `out` ends only what it sends, `in` acts as if the client had ended its direction",
        state=True,
        choices={**_ANY, **_WAY},
    ),
    "freeze": Fault(
        "on connections that stay open, sends nothing (`out`), and no packet of the client arrives (`in`)",
        state=True,
        choices={**_ANY, **_WAY},
    ),
    "slow": Fault("sends `rate` packages a second", {"rate": 2.0}, state=True, choices=_RTDE),
    "late": Fault("sends each package `delay` seconds after its time", {"delay": 0.5}, state=True, choices=_RTDE),
    "repeat": Fault("sends the same package again and again: its time stands", state=True, choices=_RTDE),
    "loss": Fault("leaves out `part` of its packages", {"part": 0.5}, state=True, choices=_RTDE),
    "corrupt": Fault("flips bits in the values of each package", state=True, choices=_RTDE),
    "truncate": Fault("sends the first half of each package only", state=True, choices=_RTDE),
    "garbage": Fault("sends `bytes` bytes of noise in place of each package", {"bytes": 64.0}, choices=_RTDE),
}


class RtdeServer:
    """Serves RTDE of one controller.

    Parameters
    ----------
    host, port
        Where; port 0 takes a free one.
    controller
        Controller whose values it sends and whose registers it sets.
    faults
        Faults of the stand-in.
    """

    def __init__(self, host: str, port: int, controller: Controller, faults: Faults) -> None:
        self._controller, self._faults = controller, faults
        self._sessions: list[RtdeSession] = []
        self._claims: dict[str, RtdeSession] = {}
        self._answers: dict[str, Callable[[RtdeSession, bytes], bytes | None]] = {
            "V": self._version,
            "v": lambda session, payload: struct.pack(">4I", *controller.profile.version),
            "O": self._outputs,
            "I": self._inputs,
            "S": lambda session, payload: self._start(session, on=True),
            "P": lambda session, payload: self._start(session, on=False),
            "U": self._update,
            "M": self._note,
        }
        self.server = TcpServer(host, port, self._serve, lambda: faults.shown("drop") is not None)

    def tell(self) -> None:
        """Send every client what is due in this cycle; under the controller's lock."""
        for session in list(self._sessions):
            self._hear_or_not(session)
            if not session.started:
                continue
            session.cycle += 1
            if session.cycle % session.every == 0:
                for data in self._packages(session):
                    self._send(session, data)

    def sever(self, fault: str) -> None:
        """End the connections that a fault meets; under the controller's lock."""
        direction = self._faults.chosen(fault).get("direction", "both")
        for session in list(self._sessions):
            if self._meets(fault, session):
                sever(session.connection, direction, reset=fault == "reset")

    def _meets(self, fault: str, session: RtdeSession, **asked: str) -> bool:
        return any(self._faults.meets(fault, connection=name, **asked) for name in ("rtde", session.kind))

    def _hear_or_not(self, session: RtdeSession) -> None:
        deaf = self._meets("freeze", session, direction="in")
        if deaf is not session.deaf:
            deafen(session.connection, deaf)
            session.deaf = deaf

    def _serve(self, connection: socket.socket) -> None:
        session, packages = RtdeSession(connection), Packages()
        with self._controller.lock:
            self._sessions.append(session)
        try:
            for data in received(connection):
                if not self._meets("freeze", session, direction="in"):
                    for kind, payload in packages.feed(data):
                        self._take(session, kind, payload)
        except Unpackable:
            return
        finally:
            with self._controller.lock:
                self._sessions.remove(session)
                self._claims = {name: owner for name, owner in self._claims.items() if owner is not session}

    def _take(self, session: RtdeSession, kind: str, payload: bytes) -> None:
        with self._controller.lock:
            asked = self._answers.get(kind)
            answer = asked(session, payload) if asked is not None else None
            if answer is not None:
                session.connection.sendall(package(kind, answer))

    def _send(self, session: RtdeSession, data: bytes) -> None:
        """Send without waiting; a client that does not read is left."""
        with suppress(OSError, ValueError):  # ValueError: the connection was closed meanwhile
            writable = bool(select.select([], [session.connection], [], 0.0)[1])
            if not writable or session.connection.send(data) < len(data):
                session.started = False
                session.connection.shutdown(socket.SHUT_RDWR)

    # --- what is asked

    def _version(self, session: RtdeSession, payload: bytes) -> bytes:
        asked = int.from_bytes(payload, "big")
        if len(payload) != 2 or asked not in _PROTOCOLS:
            return b"\x00"
        session.protocol = asked
        return b"\x01"

    def _outputs(self, session: RtdeSession, payload: bytes) -> bytes:
        if session.protocol == 1:
            return self._recipe(session, min(_FIRST_RATE, self._controller.profile.rate), _names(payload))
        if len(payload) < 8:
            raise Unpackable("an output recipe without a rate")
        (rate,) = struct.unpack(">d", payload[:8])
        names = _names(payload[8:])
        if not 0 < rate <= self._controller.profile.rate or not names:
            return b"\x00"
        return b"\x01" + self._recipe(session, rate, names)

    def _recipe(self, session: RtdeSession, rate: float, names: list[str]) -> bytes:
        """Return the types of an output recipe, and take it when all of its fields are there."""
        version = self._controller.profile.version
        fields = [found(OUTPUT_FIELDS, name, version) for name in names]
        types = [field.kind if field else _NOT_FOUND for field in fields]
        if _NOT_FOUND not in types:
            cycles = min(max(self._controller.profile.rate / rate, 1), _SELDOM)
            session.tell(types, [OUTPUTS[name] for name in names], round(cycles))
        return ",".join(types).encode()

    def _inputs(self, session: RtdeSession, payload: bytes) -> bytes:
        names = _names(payload)
        types = [self._input_type(session, name) for name in names]
        number = len(session.inputs) + 1
        if not names or {_IN_USE, _NOT_FOUND} & set(types) or number > 255:
            return b"\x00" + ",".join(types).encode()
        session.inputs[number] = names
        self._claims.update(dict.fromkeys(names, session))
        return bytes([number]) + ",".join(types).encode()

    def _input_type(self, session: RtdeSession, name: str) -> str:
        field = found(INPUT_FIELDS, name, self._controller.profile.version)
        taken = self._faults.shown("registers") is not None and "register" in name
        if taken or self._claims.get(name, session) is not session:
            return _IN_USE
        return field.kind if field else _NOT_FOUND

    def _start(self, session: RtdeSession, *, on: bool) -> bytes:
        session.started = on and bool(session.asks)
        return bytes([session.started if on else True])

    def _update(self, session: RtdeSession, payload: bytes) -> None:
        names = session.inputs.get(payload[0]) if payload else None
        if names is None:
            return
        types = [INPUT_FIELDS[name].kind for name in names]
        if len(payload) - 1 == size_of(types):
            self._controller.take(dict(zip(names, unpack(types, payload[1:]), strict=True)))

    def _note(self, session: RtdeSession, payload: bytes) -> None:
        """Write a client's message down."""
        self._controller.note(f"a client says: {text_of(payload, session.protocol)}")

    # --- what goes out

    def _packages(self, session: RtdeSession) -> list[bytes]:
        """Return what goes out in a cycle, as the active faults let it."""
        now = self._controller.time
        if self._meets("freeze", session, direction="out"):
            return []
        slow, late, loss = (self._shown(session, name) for name in ("slow", "late", "loss"))
        if slow is not None:
            if now < session.due:
                return []
            session.due = now + 1 / max(slow["rate"], 1e-3)
        if loss is not None and (session.cycle * 0.618) % 1.0 < loss["part"]:
            return []
        if self._shown(session, "repeat") is None or not session.last:
            session.last = session.data(self._controller)
        data = self._broken(session, session.last)
        session.held.append((now + (late["delay"] if late is not None else 0.0), data))
        ready = []
        while session.held and session.held[0][0] <= now:
            ready.append(session.held.popleft()[1])
        return ready

    def _broken(self, session: RtdeSession, data: bytes) -> bytes:
        if self._shown(session, "corrupt") is not None:
            data = data[:4] + bytes(byte ^ 0x5A for byte in data[4:])
        if self._shown(session, "truncate") is not None:
            data = data[: len(data) // 2]
        garbage = self._shown(session, "garbage")
        if garbage is not None:
            data = bytes((37 * k + 11) % 251 for k in range(min(int(garbage["bytes"]), 1 << 16)))
        return data

    def _shown(self, session: RtdeSession, fault: str) -> dict[str, float] | None:
        """Return the parameters of a fault that meets a client."""
        return self._faults.shown(fault) if self._meets(fault, session) else None


def _names(payload: bytes) -> list[str]:
    """Return the names of a recipe; a comma may be at its end."""
    return [name for name in payload.decode("ascii", "replace").split(",") if name]
