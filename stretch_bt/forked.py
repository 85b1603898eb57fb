"""A child process that own code forked: it has no part in the run, and leaves before it stops, prints or writes anything."""

from __future__ import annotations

import os
from contextlib import contextmanager

TYPE_CHECKING = False  # see stretch_bt/__init__.py
if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["alone", "here", "leave_if_forked"]


class Here:
    """Whether this process was forked from one that is in a block of `alone`."""

    forked = False
    depth = 0


#: state of this process; a tick looks at it, so that it costs next to nothing
here = Here()


def _forked() -> None:
    here.forked = here.depth > 0


os.register_at_fork(after_in_child=_forked)


def leave_if_forked() -> None:
    """End a forked child at once: devices, record and outputs belong to the process that began the run."""
    if here.forked:
        os._exit(0)


@contextmanager
def alone() -> Iterator[None]:
    """Go through the block in this process alone: a child that is forked within leaves where it would come out."""
    before, here.forked = here.forked, False  # a child that begins a run of its own ends that
    here.depth += 1
    pid = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != pid:
            os._exit(0)
        here.depth -= 1
        here.forked = before
