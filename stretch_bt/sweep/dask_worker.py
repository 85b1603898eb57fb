"""What a Dask worker that a sweep starts on this machine loads first."""

from __future__ import annotations

import signal
from typing import Any

__all__ = ["dask_setup"]


def dask_setup(_: Any) -> None:
    """Leave Ctrl-C to the sweep, which ends its workers: each would print where it was."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
