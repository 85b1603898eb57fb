"""A small TCP server that a fault can break in every way a network breaks."""

from __future__ import annotations

import ctypes
import os
import re
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress

__all__ = ["TcpServer", "batches", "cannot_listen", "deafen", "is_web", "lines", "received", "sever", "unless_web"]

_POLL = 0.1
_PART = 4096
#: number of bytes in which the first line of a request of HTTP is looked for
_BEGIN = 2 * _PART
#: a socket address of no family, to which a TCP connection is "connected" to reset it; options of Linux for packet filters
_NOWHERE = struct.pack("=H14x", socket.AF_UNSPEC)
_ATTACH_FILTER, _DETACH_FILTER = 26, 27
#: a filter that drops every packet
_DROP_ALL = struct.pack("=HBBI", 6, 0, 0, 0)
#: the first line of an HTTP request (RFC 9112, section 3)
_REQUEST = re.compile(rb"[!-~]+ [^ ]+ HTTP/\d")
_WAYS = {"both": socket.SHUT_RDWR, "out": socket.SHUT_WR, "in": socket.SHUT_RD}


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
    """Yield the lines that come, without their ends, up to one that has `longest` bytes before its end."""
    for whole in batches(connection, longest):
        yield from whole


def batches(connection: socket.socket, longest: int) -> Iterator[list[bytes]]:
    """Yield the lines that come together, as `lines` does one by one.

    Nothing is yielded of a request of HTTP: any page that a browser shows could send one here, with commands as its body.
    """
    rest, first = b"", True
    for data in received(connection):
        *whole, rest = (rest + data).split(b"\n")
        if any(len(line) >= longest for line in whole) or (first and whole and is_web(whole[0])):
            return
        if whole:
            first = False
            yield whole
        if len(rest) >= longest:
            return


def unless_web(connection: socket.socket) -> Iterator[bytes]:
    """Yield what comes over a connection, but of a request of HTTP nothing past its first line."""
    begin = b""
    for data in received(connection):
        if len(begin) < _BEGIN:
            begin += data
        if is_web(begin.partition(b"\n")[0]):
            return
        yield data


def is_web(line: bytes) -> bool:
    """Return whether a line is the first one of an HTTP request."""
    return _REQUEST.match(line) is not None


def sever(connection: socket.socket, direction: str = "both", *, reset: bool = False) -> None:
    """End a connection at once, by a reset or a FIN, whatever other threads do with it.

    Of its directions `out` ends for what is sent, `in` as if the other side had ended its own.
    """
    with suppress(OSError):
        if not reset:
            connection.shutdown(_WAYS[direction])
        elif ctypes.CDLL(None, use_errno=True).connect(connection.fileno(), _NOWHERE, len(_NOWHERE)):
            connection.shutdown(socket.SHUT_RDWR)


def deafen(connection: socket.socket, deaf: bool) -> None:
    """Have the kernel drop every packet that comes for a connection, confirmations too, as a cable does that is broken one way; or not any more."""
    with suppress(OSError):
        if deaf:
            code = ctypes.create_string_buffer(_DROP_ALL)
            connection.setsockopt(socket.SOL_SOCKET, _ATTACH_FILTER, struct.pack("@HP", 1, ctypes.addressof(code)))
        else:
            connection.setsockopt(socket.SOL_SOCKET, _DETACH_FILTER, 0)


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

    def break_all(self, direction: str = "both", *, reset: bool = False) -> None:
        """End all connections, as `sever` does."""
        with self._lock:
            for connection in self._open:
                sever(connection, direction, reset=reset)

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
