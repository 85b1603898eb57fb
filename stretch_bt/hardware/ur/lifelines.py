"""The connections of a process to its controller, watched from a thread of its own: the process ends at once when one is lost.

The client that controls reconnects by itself: it ends the program on the controller, uploads its script anew, and sends the setpoint
that it was asked for, without anybody's knowledge. It must not come to that.
"""

from __future__ import annotations

import os
import resource
import select
import socket
import struct
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from stretch_bt.hardware.child import LAST_WORD

__all__ = ["Lifelines", "Link", "end_process", "trouble"]

_OPEN_FILES = Path("/proc/self/fd")
#: how often silence is looked at, ms; a connection that ends wakes the thread by itself
_EVERY = 5
_ENDED = select.POLLRDHUP | select.POLLHUP | select.POLLERR
#: from linux/tcp.h: state of a connection that is open both ways; size of what is asked for; place of the time since data came, ms
_ESTABLISHED, _INFO_SIZE, _LAST_RECEIVED = 1, 104, 52
#: standard input, output and error, which are always open
_STANDARD = 3


@dataclass(frozen=True, slots=True)
class Link:
    """How a TCP connection stands: whether it is open both ways, and for how long nothing came, s."""

    whole: bool
    silent: float


def trouble(name: str, link: Link, silent_after: float) -> str | None:
    """Return what is wrong with a connection, or None."""
    if not link.whole:
        return f"the connection that {name} was closed or reset by the controller"
    if link.silent > silent_after:
        return f"nothing new came from the controller for {link.silent:.2g} s by the connection that {name}"
    return None


def end_process(reason: str) -> NoReturn:
    """End this process at once, and leave the reason as its last word; from any thread."""
    os.write(sys.stderr.fileno(), f"\n{LAST_WORD}{reason}\n".encode())
    os._exit(1)


class Lifelines:
    """Watches the connections of this process to one port.

    Parameters
    ----------
    port
        Port of the controller.
    silent_after
        How long nothing may come by a connection, s.
    """

    def __init__(self, port: int, silent_after: float) -> None:
        self._port, self._silent_after = port, silent_after
        self._held: dict[int, tuple[str, socket.socket]] = {}
        self._inodes: set[str] = set()
        self._poll = select.poll()
        self._thread = threading.Thread(target=self._run, name="lifelines", daemon=True)

    def hold(self, name: str) -> None:
        """Watch the connections that are new since this was called last, by copies of their descriptors.

        Parameters
        ----------
        name
            What they do, for messages, as in "the connection that reads".

        Raises
        ------
        OSError
            There is no new connection.
        """
        found = list(self._new())
        if not found:
            raise OSError(f"the connection that {name} was lost before it could be watched")
        for connection in found:
            self._held[connection.fileno()] = name, connection
            self._poll.register(connection, _ENDED)
        if not self._thread.is_alive():
            self._thread.start()

    def forbid_more(self) -> None:
        """Have the kernel refuse this process every further descriptor, and so every further connection."""
        resource.setrlimit(resource.RLIMIT_NOFILE, (_STANDARD, _STANDARD))

    def _new(self) -> list[socket.socket]:
        found = []
        for entry in _OPEN_FILES.iterdir():
            try:
                inode = str(entry.readlink())
                if not inode.startswith("socket:") or inode in self._inodes:
                    continue
                connection = socket.socket(fileno=os.dup(int(entry.name)))
            except OSError:  # it was closed meanwhile
                continue
            if _peer_port(connection) == self._port:
                self._inodes.add(inode)
                found.append(connection)
            else:
                connection.close()
        return found

    def _run(self) -> None:
        while True:
            self._poll.poll(_EVERY)
            for name, connection in list(self._held.values()):
                if (reason := trouble(name, _link(connection), self._silent_after)) is not None:
                    end_process(reason)


def _peer_port(connection: socket.socket) -> int | None:
    try:
        peer = connection.getpeername()
    except OSError:
        return None
    return peer[1] if isinstance(peer, tuple) else None


def _link(connection: socket.socket) -> Link:
    info = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _INFO_SIZE)
    (milliseconds,) = struct.unpack_from("=I", info, _LAST_RECEIVED)
    return Link(info[0] == _ESTABLISHED, milliseconds / 1e3)
