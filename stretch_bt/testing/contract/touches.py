"""What code reaches outside of its process, by the interpreter's audit events."""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import active_children
from typing import Any, ClassVar

__all__ = ["touches"]

#: by event, the index of its argument that says what is reached
_EVENTS = {
    "socket.connect": 1,
    "socket.bind": 1,
    "socket.sendto": 1,
    "socket.sendmsg": 1,
    "subprocess.Popen": 0,
    "os.system": 0,
    "os.posix_spawn": 0,
    "os.spawn": 1,
    "os.exec": 0,
    "os.startfile": 0,
    "os.fork": None,
    "os.forkpty": None,
    "pty.spawn": 0,
    "open": 0,
}
#: files that are a device, and those in the same folder that are not
_DEVICE = re.compile(r"/dev/(?!(null|zero|full|u?random|std\w+|fd|shm)\b)|COM\d|\\\\\.\\")


class _Heard:
    """What the interpreter reports while it listens; such a hook cannot be taken away again."""

    listening = False
    touched: ClassVar[list[str]] = []
    others: ClassVar[set[int]] = set()
    hooked = False

    @classmethod
    def hear(cls, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event that reaches out of the process."""
        if not cls.listening or event not in _EVENTS or threading.get_ident() in cls.others:
            return
        of = _EVENTS[event]
        what = "" if of is None else str(arguments[of])
        if event != "open" or _DEVICE.match(what):
            cls.touched.append(f"{event} {what}".rstrip())


@contextmanager
def touches() -> Iterator[list[str]]:
    """Give what the block reaches outside, in this thread or in one that it starts; in words, as `socket.connect ('10.0.0.2', 502)`."""
    if not _Heard.hooked:
        sys.addaudithook(_Heard.hear)
        _Heard.hooked = True
    _Heard.touched.clear()
    here = threading.get_ident()
    _Heard.others = {thread.ident for thread in threading.enumerate() if thread.ident not in (None, here)}
    children = set(active_children())
    _Heard.listening = True
    try:
        yield _Heard.touched
    finally:
        _Heard.listening = False
        _Heard.touched += [f"process {child.name}" for child in set(active_children()) - children]
