"""Giving back what an item of a sweep has used of memory, so that a worker does not grow."""

from __future__ import annotations

import ctypes
import gc

__all__ = ["give_back"]


def give_back() -> None:
    """Collect what nothing names any more, and hand the pages that are free to the system, where its C library can (glibc).

    Worlds hold each other in cycles, and a worker would grow by half between two collections. What is freed lies in pieces between what
    is kept, and by these it would grow by a quarter over 60 items.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
