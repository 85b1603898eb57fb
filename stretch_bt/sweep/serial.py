"""The engine that runs one item after the other in this process."""

from __future__ import annotations

from collections.abc import Generator, Iterable

from stretch_bt.sweep.run_item import run_item
from stretch_bt.sweep.spec import Ran, Spec

__all__ = ["serial"]


def serial(specs: Iterable[Spec]) -> Generator[Ran, None, None]:
    """Yield what comes of each item; a signal, which a run takes to end safely, ends the sweep too."""
    for spec in specs:
        ran = run_item(spec)
        if ran.stopped:
            raise KeyboardInterrupt(ran.row["reason"])
        yield ran
