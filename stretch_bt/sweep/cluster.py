"""The engine that runs items on the workers of a Dask scheduler: processes of this machine, or of any others."""

from __future__ import annotations

import logging
import uuid
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from queue import Empty, Queue
from typing import Any

from stretch_bt.errors import InvalidInput, MissingExtra, StretchError, named
from stretch_bt.sweep import dask_worker
from stretch_bt.sweep.crew import Crew, cannot_run
from stretch_bt.sweep.dask_scheduler import address_of, await_scheduler, quiet
from stretch_bt.sweep.job import Job, Ran

__all__ = ["cluster"]

#: time after which a worker of this machine that died and did not come back is given up; by default one that dies again while
#: it begins would be, and in the end all of them
LOST = "365 days"
#: longest wait for a message between processes of this machine, which may be busy
PATIENCE = "5 minutes"
#: time between two looks for workers that have joined, s, while no item ends: one without the package breaks on its first
#: item without a word
LOOK = 10.0
#: settings of the processes of this machine; a worker would keep a picture of its stack of every 10 ms, for an hour
_SETTINGS = {
    "distributed.deploy.lost-worker-timeout": LOST,
    "distributed.comm.timeouts.connect": PATIENCE,
    "distributed.worker.profile.enabled": False,
}


def cluster(
    jobs: Iterable[Job], workers: int, scheduler: str | None = None, say: Callable[[str], None] = lambda _: None
) -> Generator[Ran, None, None]:
    """Yield what comes of each item, in the order in which they end.

    Without the address of a scheduler, that many worker processes are started on this machine. No more items are
    handed out than there are workers: Dask holds all that a worker has against it when it dies, not only what it runs.
    Dask runs an item whose worker died on another one; one that three more die of is `killed`.

    Raises
    ------
    MissingExtra
        dask.distributed is not installed.
    InvalidInput
        A worker has more than one thread, or another `stretch_bt`; or there is no scheduler at the address.
    StretchError
        The scheduler is gone.
    """
    ahead = iter(jobs)
    with _client(workers, scheduler) as client:
        running: dict[str, tuple[Any, Job]] = {}
        ended: Queue[Any] = Queue()
        crew = Crew(client, ask=scheduler is not None)
        while True:
            for job in islice(ahead, _free(crew, len(running), say)):
                future = client.submit(_run, job, key=f"{job.key}-{uuid.uuid4().hex}")
                running[future.key] = future, job
                future.add_done_callback(ended.put)
            if not running:
                return
            with suppress(Empty):
                yield _ended(ended.get(timeout=LOOK), running)


def _run(job: Job) -> Ran:
    return job.run()


def _ended(future: Any, running: dict[str, tuple[Any, Job]]) -> Ran:
    """Return what comes of an item that has ended; Dask forgets it, or it would run it again if its worker died."""
    _, job = running.pop(future.key)
    try:
        return _ran(future, job)
    finally:
        future.release()


def _free(crew: Crew, running: int, say: Callable[[str], None]) -> int:
    """Return how many items may be handed out, once there is any worker."""
    with _told():
        workers = crew.look()
        if not workers and not running:
            say("waiting for a worker")
            crew.wait()
            workers = crew.look()
    return max(workers - running, 0)


def _ran(future: Any, job: Job) -> Ran:
    """Return what a future holds.

    Raises
    ------
    StretchError
        The item did not come to a row: its worker cannot run any, or the scheduler is gone.
    """
    from distributed import KilledWorker

    try:
        ran: Ran = future.result()
    except KilledWorker:
        return job.killed()
    except StretchError:
        raise
    except Exception as error:
        if future.cancelled() or future.status == "lost":
            raise _gone(error) from error
        raise cannot_run(named(error)) from error
    return ran


@contextmanager
def _told() -> Iterator[None]:
    """Turn what breaks between us and the scheduler into an error that says what to do."""
    try:
        yield
    except (OSError, TimeoutError) as error:
        raise _gone(error) from error


def _gone(error: Exception) -> StretchError:
    return StretchError(f"the scheduler is gone ({named(error)}); start it again, and go on with --resume")


@contextmanager
def _client(workers: int, scheduler: str | None) -> Iterator[Any]:
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise MissingExtra("the engine 'dask' needs dask.distributed: pip install 'stretch-bt[dask]'") from None
    with _of_scheduler(scheduler) if scheduler is not None else _of_here(workers) as client:
        yield client


@contextmanager
def _of_scheduler(scheduler: str) -> Iterator[Any]:
    from distributed import Client

    address = address_of(scheduler)
    try:
        await_scheduler(address)
        client = Client(address, timeout="10 s")
    except Exception as error:  # whatever a server that is none answers with
        raise InvalidInput(
            f"there is no Dask scheduler at {scheduler!r} ({named(error)}); start one with 'dask scheduler'"
        ) from None
    with quiet(), client:
        yield client


@contextmanager
def _of_here(workers: int) -> Iterator[Any]:
    import dask
    from distributed import Client, LocalCluster

    told: Any = {
        "silence_logs": logging.CRITICAL,
        "dashboard_address": "127.0.0.1:0",
        "preload": [dask_worker.__name__],
    }
    with (
        dask.config.set(_SETTINGS),
        _begun(
            lambda: LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, memory_limit=0, **told)
        ) as here,
        Client(here) as client,
    ):
        yield client


def _begun(make: Callable[[], Any]) -> Any:
    """Return what has started the workers of this machine."""
    try:
        return make()
    except RuntimeError as error:
        script = "in a script, sweep below the line 'if __name__ == \"__main__\":', for each worker reads the script"
        raise StretchError(
            f"the worker processes do not begin ({named(error)}); {script}; else run with --engine serial to see why"
        ) from None
