"""The engine that runs one item after the other in this process."""

from __future__ import annotations

from collections.abc import Generator, Iterable

from stretch_bt.sweep.job import Job, Ran

__all__ = ["serial"]


def serial(jobs: Iterable[Job]) -> Generator[Ran, None, None]:
    """Yield what comes of each item; a signal, which a run takes to end safely, ends the sweep too."""
    for job in jobs:
        ran = job.run()
        if ran.stopped:
            raise KeyboardInterrupt(ran.row["reason"])
        yield ran
