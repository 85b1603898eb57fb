"""A place in front of the other processes of a machine."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

__all__ = ["raise_priority"]

#: higher than the priority of everything else that does not ask for more
_PRIORITY = -10


def raise_priority() -> None:
    """Have this process go before others, where its user may; one that has a session of its own, on Linux that session too.

    Where the kernel shares its time out to sessions first, which is usual, the priority of a process counts only within its own.
    """
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, _PRIORITY)
        if os.getsid(0) == os.getpid():
            Path("/proc/self/autogroup").write_text(str(_PRIORITY))
