"""A port that sends each of its clients the state of the robot at a rate, and takes programs from them."""

from __future__ import annotations

import select
import socket
from collections.abc import Callable

from stretch_bt.hardware.emulators.faults import Faults
from stretch_bt.hardware.emulators.tcp_server import TcpServer, received
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.script_reader import ScriptReader

__all__ = ["ClientPort", "sent"]

Message = Callable[[Controller], bytes]

#: bytes that wait for a client, here and in its connection: one that never reads costs nothing once they are full
_BUFFER = 1 << 15


class ClientPort:
    """One of the ports 30001 to 30003, or of the ports that only send.

    Parameters
    ----------
    host, port
        Where; port 0 takes a free one.
    controller
        Controller whose state it sends.
    faults
        Faults of the stand-in.
    state
        Returns the message that goes out `rate` times a second.
    rate
        Rate of that message, at most the controller's own.
    greeting
        Returns the message for a client that connects; None where there is none.
    load
        Takes the text of a program; None where clients may send none.
    """

    def __init__(
        self,
        host: str,
        port: int,
        controller: Controller,
        faults: Faults,
        *,
        state: Message,
        rate: float,
        greeting: Message | None = None,
        load: Callable[[str], None] | None = None,
    ) -> None:
        self._controller, self._faults = controller, faults
        self._state, self._greeting, self._load = state, greeting, load
        self._every = max(round(controller.profile.rate / rate), 1)
        self._cycle = 0
        #: by client, the bytes that its connection did not take yet
        self._clients: dict[socket.socket, bytes] = {}
        self.server = TcpServer(host, port, self._serve, lambda: faults.shown("drop") is not None)

    def tell(self) -> None:
        """Send the state to every client when it is due in this cycle; under the controller's lock."""
        self._cycle += 1
        if self._clients and self._cycle % self._every == 0:
            self.send(self._state)

    def send(self, message: Message) -> None:
        """Send a message to every client that has not left too many; under the controller's lock."""
        if self._faults.meets("freeze", connection="script", direction="out"):
            return
        waiting = [client for client, rest in self._clients.items() if len(rest) < _BUFFER]
        if waiting:
            data = message(self._controller)
            for client in waiting:
                self._clients[client] = sent(client, self._clients[client] + data)

    def _serve(self, connection: socket.socket) -> None:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
        with self._controller.lock:
            greeting = b"" if self._greeting is None else self._greeting(self._controller)
            self._clients[connection] = sent(connection, greeting)
        reader = ScriptReader()
        try:
            for data in received(connection):
                if self._load is None or self._faults.meets("freeze", connection="script", direction="in"):
                    continue
                for program in reader.feed(data):
                    self._load(program)
                if reader.web:
                    return
        finally:
            with self._controller.lock:
                del self._clients[connection]


def sent(connection: socket.socket, data: bytes) -> bytes:
    """Send what goes without waiting, and return the rest; a send that may wait would wait for the socket's own timeout."""
    try:
        if not select.select([], [connection], [], 0.0)[1]:
            return data
        return data[connection.send(data, socket.MSG_DONTWAIT) :]
    except BlockingIOError:
        return data
    except (OSError, ValueError):  # it is closed: who reads from it sees that
        return b""
