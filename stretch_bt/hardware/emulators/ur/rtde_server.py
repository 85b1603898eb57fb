"""The side of RTDE that the controller has: recipes, claims on inputs, and packages at a rate."""

from __future__ import annotations

import select
import socket
import struct
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field

from stretch_bt.hardware.emulators.faults import Fault, Faults
from stretch_bt.hardware.emulators.tcp_server import TcpServer, deafen, received, sever
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.variables import INPUTS, OUTPUTS, Ask
from stretch_bt.hardware.emulators.ur.wire import Packages, Unpackable, pack, package, size_of, unpack

__all__ = ["STREAM_FAULTS", "RtdeServer"]

#: only newer controllers have them
_LATER = {"ft_raw_wrench"}

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


@dataclass(eq=False)
class _Session:
    """One client: what it is sent, what it may set."""

    connection: socket.socket
    every: int = 1
    types: list[str] = field(default_factory=list)
    asks: list[Ask] = field(default_factory=list)
    inputs: dict[int, list[str]] = field(default_factory=dict)
    started: bool = False
    cycle: int = 0
    due: float = 0.0
    held: deque[tuple[float, bytes]] = field(default_factory=deque)
    last: bytes = b""
    deaf: bool = False

    @property
    def kind(self) -> str:
        """What the client does: it controls where it has inputs."""
        return "control" if self.inputs else "receive"


class RtdeServer:
    """Serves RTDE of one controller.

    Parameters
    ----------
    host, port
        Where; port 0 takes a free one.
    controller
        Whose values it tells and whose registers it sets.
    faults
        Of the stand-in.
    """

    def __init__(self, host: str, port: int, controller: Controller, faults: Faults) -> None:
        self._controller, self._faults = controller, faults
        self._sessions: list[_Session] = []
        self._claims: dict[str, _Session] = {}
        self._answers: dict[str, Callable[[_Session, bytes], bytes | None]] = {
            "V": self._version,
            "v": lambda session, payload: struct.pack(">4I", *controller.profile.version),
            "O": self._outputs,
            "I": self._inputs,
            "S": lambda session, payload: self._start(session, on=True),
            "P": lambda session, payload: self._start(session, on=False),
            "U": self._update,
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

    def _meets(self, fault: str, session: _Session, **asked: str) -> bool:
        return any(self._faults.meets(fault, connection=name, **asked) for name in ("rtde", session.kind))

    def _hear_or_not(self, session: _Session) -> None:
        deaf = self._meets("freeze", session, direction="in")
        if deaf is not session.deaf:
            deafen(session.connection, deaf)
            session.deaf = deaf

    def _serve(self, connection: socket.socket) -> None:
        session, packages = _Session(connection), Packages()
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

    def _take(self, session: _Session, kind: str, payload: bytes) -> None:
        with self._controller.lock:
            asked = self._answers.get(kind)
            answer = asked(session, payload) if asked is not None else None
            if answer is not None:
                session.connection.sendall(package(kind, answer))

    def _send(self, session: _Session, data: bytes) -> None:
        """Send without waiting; a client that does not read is left."""
        with suppress(OSError, ValueError):  # ValueError: the connection was closed meanwhile
            writable = bool(select.select([], [session.connection], [], 0.0)[1])
            if not writable or session.connection.send(data) < len(data):
                session.started = False
                session.connection.shutdown(socket.SHUT_RDWR)

    # --- what is asked

    def _version(self, session: _Session, payload: bytes) -> bytes:
        return b"\x01" if payload == b"\x00\x02" else b"\x00"

    def _outputs(self, session: _Session, payload: bytes) -> bytes:
        if len(payload) < 8:
            raise Unpackable("an output recipe without a rate")
        (rate,) = struct.unpack(">d", payload[:8])
        names = _names(payload[8:])
        later = set() if self._controller.profile.e_series else _LATER
        found = [OUTPUTS.get(name) if name not in later else None for name in names]
        types = [entry[0] if entry else "NOT_FOUND" for entry in found]
        if not 0 < rate <= self._controller.profile.rate or not names:
            return b"\x00"
        if "NOT_FOUND" not in types:
            session.types, session.asks = types, [entry[1] for entry in found if entry]
            session.every = max(round(self._controller.profile.rate / rate), 1)
        return b"\x01" + ",".join(types).encode()

    def _inputs(self, session: _Session, payload: bytes) -> bytes:
        names = _names(payload)
        taken = self._faults.shown("registers") is not None
        types = []
        for name in names:
            owner = self._claims.get(name)
            in_use = (owner is not None and owner is not session) or (taken and "register" in name)
            types.append("IN_USE" if in_use else INPUTS.get(name, "NOT_FOUND"))
        if not names or {"IN_USE", "NOT_FOUND"} & set(types):
            return b"\x00" + ",".join(types).encode()
        number = len(session.inputs) + 1
        if number > 255:
            return b"\x00"
        session.inputs[number] = names
        self._claims.update(dict.fromkeys(names, session))
        return bytes([number]) + ",".join(types).encode()

    def _start(self, session: _Session, *, on: bool) -> bytes:
        session.started = on and bool(session.types)
        return bytes([session.started if on else True])

    def _update(self, session: _Session, payload: bytes) -> None:
        names = session.inputs.get(payload[0]) if payload else None
        if names is None:
            return
        types = [INPUTS[name] for name in names]
        if len(payload) - 1 == size_of(types):
            self._controller.take(dict(zip(names, unpack(types, payload[1:]), strict=True)))

    # --- what goes out

    def _packages(self, session: _Session) -> list[bytes]:
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
            session.last = package("U", b"\x01" + pack(session.types, [ask(self._controller) for ask in session.asks]))
        data = self._broken(session, session.last)
        session.held.append((now + (late["delay"] if late is not None else 0.0), data))
        ready = []
        while session.held and session.held[0][0] <= now:
            ready.append(session.held.popleft()[1])
        return ready

    def _broken(self, session: _Session, data: bytes) -> bytes:
        if self._shown(session, "corrupt") is not None:
            data = data[:4] + bytes(byte ^ 0x5A for byte in data[4:])
        if self._shown(session, "truncate") is not None:
            data = data[: len(data) // 2]
        garbage = self._shown(session, "garbage")
        if garbage is not None:
            data = bytes((37 * k + 11) % 251 for k in range(min(int(garbage["bytes"]), 1 << 16)))
        return data

    def _shown(self, session: _Session, fault: str) -> dict[str, float] | None:
        """Return the parameters of a fault that meets a client."""
        return self._faults.shown(fault) if self._meets(fault, session) else None


def _names(payload: bytes) -> list[str]:
    """Return the names of a recipe; a comma may be at its end."""
    return [name for name in payload.decode("ascii", "replace").split(",") if name]
