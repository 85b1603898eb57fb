"""The engines by name."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean
from stretch_bt.sweep.cluster import cluster
from stretch_bt.sweep.job import Job, Ran
from stretch_bt.sweep.local import local
from stretch_bt.sweep.serial import serial

__all__ = ["ENGINES", "Engine", "engine_of"]

Engine = Callable[[Iterable[Job]], Generator[Ran, None, None]]

ENGINES = {
    "serial": "one item after the other in this process",
    "local": "processes of this machine, by joblib",
    "dask": "workers of a Dask scheduler, or processes of this machine",
}


def engine_of(
    name: str | None, workers: int | None, scheduler: str | None, say: Callable[[str], None] = lambda _: None
) -> Engine:
    """Return the engine of a name; by default `dask` where a scheduler is named, else `serial`.

    Raises
    ------
    InvalidInput
        There is no such engine, or it has no use for what is given.
    """
    name = name or ("serial" if scheduler is None else "dask")
    if name not in ENGINES:
        raise InvalidInput(f"there is no engine {name!r}; {did_you_mean(name, ENGINES)}")
    if scheduler is not None and name != "dask":
        raise InvalidInput(f"--scheduler is for the engine dask, not {name}; leave one of them out")
    if workers is not None and (name == "serial" or scheduler is not None):
        whose = "runs in this process" if name == "serial" else "has the workers of its scheduler"
        raise InvalidInput(f"--workers: the engine {name} {whose}; leave it out")
    if workers is not None and workers < 1:
        raise InvalidInput(f"--workers: {workers} is no number of processes; write 1 or more")
    count = workers or len(os.sched_getaffinity(0))
    if name == "serial":
        return serial
    if name == "local":
        return lambda jobs: local(jobs, count)
    return lambda jobs: cluster(jobs, count, scheduler, say)
