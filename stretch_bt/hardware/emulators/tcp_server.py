"""A small TCP server that a fault can break in every way a network breaks."""

from __future__ import annotations

import os
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress

__all__ = ["TcpServer", "cannot_listen", "lines", "received"]

_POLL = 0.1
_PART = 4096
_RESET = struct.pack("ii", 1, 0)


def received(connection: socket.socket) -> Iterator[bytes]:
    """Yield what comes over a connection of the server, until the other side ends it."""
    while True:
        try:
            data = connection.recv(_PART)
        except TimeoutError:
            continue
        if not data:
            return
        yield data


def lines(connection: socket.socket, longest: int) -> Iterator[bytes]:
    """Yield the lines that come, without their ends; one that has `longest` bytes before its end is the last."""
    rest = b""
    for data in received(connection):
        *whole, rest = (rest + data).split(b"\n")
        yield from whole
        if len(rest) >= longest:
            return


def cannot_listen(host: str, port: int, error: OSError) -> OSError:
    """Return the error that says which port cannot be had, and what to do."""
    why = os.strerror(error.errno) if error.errno else str(error)
    return OSError(
        f"cannot listen on {host} port {port}: {why}; is another stand-in running there? Choose another --host or --port"
    )


class TcpServer:
    """Calls `serve(connection)` in a thread for each connection, until `stop`; a connection is closed when that returns.

    While `refuses()` new connections are closed at once. Raises OSError, with what to do, when the port cannot be had.
    """

    def __init__(
        self,
        host: str,
        port: int,
        serve: Callable[[socket.socket], None],
        refuses: Callable[[], bool] = lambda: False,
    ) -> None:
        self._serve, self._refuses = serve, refuses
        self._lock = threading.Lock()
        self._open: dict[socket.socket, threading.Thread] = {}
        self._ending = threading.Event()
        try:
            self._listener = socket.create_server((host, port))
        except OSError as error:
            raise cannot_listen(host, port, error) from error
        self._listener.settimeout(_POLL)
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        self._thread = threading.Thread(target=self._accept, name=f"server on {host}:{port}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Close all connections and the port, and wait for the threads."""
        self._ending.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)  # wakes who waits for a connection
        self._thread.join()
        self._listener.close()
        threads = list(self._open.values())
        self.break_all()
        for thread in threads:
            thread.join(2.0)

    def break_all(self, *, reset: bool = False) -> None:
        """Close all connections, by a reset where asked."""
        with self._lock:
            for connection in self._open:
                with suppress(OSError):
                    if reset:
                        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
                        connection.close()
                    else:
                        connection.shutdown(socket.SHUT_RDWR)

    def _accept(self) -> None:
        while not self._ending.is_set():
            try:
                connection, _ = self._listener.accept()
            except OSError:  # nobody came, or the port is closed
                continue
            if self._refuses():
                connection.close()
                continue
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.settimeout(_POLL)
            thread = threading.Thread(target=self._run, args=(connection,), daemon=True)
            with self._lock:
                self._open[connection] = thread
            thread.start()

    def _run(self, connection: socket.socket) -> None:
        try:
            with connection, suppress(OSError):
                self._serve(connection)
        finally:
            with self._lock:
                self._open.pop(connection, None)
