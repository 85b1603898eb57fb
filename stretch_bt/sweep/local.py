"""The engine that runs items in processes of this machine, by joblib and its loky workers."""

from __future__ import annotations

import os
import tempfile
import threading
import time
import warnings
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import chain
from pathlib import Path

from stretch_bt.errors import MissingExtra, StretchError
from stretch_bt.sweep.job import Job, Ran

__all__ = ["local"]

#: pools that may break one after the other before any item begins in them
MOST_UNBEGUN = 3
#: joblib runs a single job in this process, where it could end the sweep
LEAST = 2


def local(jobs: Iterable[Job], workers: int) -> Generator[Ran, None, None]:
    """Yield what comes of each item, in the order in which they end.

    joblib ends the whole pool when one of its processes dies, and does not say whose item that was. Then all items
    that had begun run again, each in a pool alone: one that ends its process there is `killed`. The others go on together.

    Raises
    ------
    MissingExtra
        joblib is not installed.
    StretchError
        The processes die before they begin any item.
    """
    _check_installed()
    ahead, unbegun = iter(jobs), 0
    with tempfile.TemporaryDirectory(prefix="stretch-begun-") as name:
        begun = Path(name)
        try:
            while True:
                pool = _Pool(ahead, max(workers, LEAST), begun)
                yield from pool.rans()
                if not pool.broken:
                    _end_workers(kill=False)
                    return
                suspects, others = pool.left()
                unbegun = 0 if suspects or pool.ended else unbegun + 1
                if unbegun == MOST_UNBEGUN:
                    raise StretchError(
                        "the worker processes die before they begin an item; run with --engine serial to see why"
                    )
                for job in suspects:
                    yield _alone(job, begun)
                ahead = chain(others, ahead)
        except BaseException:
            _end_workers(kill=True)
            raise


class _Pool:
    """One pool, which goes through items until it breaks."""

    def __init__(self, jobs: Iterator[Job], workers: int, begun: Path) -> None:
        self._jobs, self._workers, self._begun = jobs, workers, begun
        self._handed: dict[str, Job] = {}
        #: items that came to a row
        self.ended = 0
        self.broken = False

    def rans(self) -> Iterator[Ran]:
        """Yield what comes of the items, until all are through or a process died."""
        from joblib import Parallel, delayed, parallel_config

        call = delayed(_marked)
        try:
            with parallel_config("loky", n_jobs=self._workers, inner_max_num_threads=1):
                parallel = Parallel(
                    return_as="generator_unordered", batch_size=1, pre_dispatch="n_jobs", max_nbytes=None
                )
                rans = parallel(call(job, str(self._begun), os.getpid()) for job in self._taken())
                with _closed(rans):
                    for ran in rans:
                        self.ended += 1
                        del self._handed[ran.row["key"]]
                        yield ran
        except BrokenProcessPool:
            self.broken = True

    def left(self) -> tuple[list[Job], list[Job]]:
        """Return the items that had begun when the pool broke, and those that had only been handed to it."""
        marks = {path.name for path in self._begun.iterdir()}
        for mark in marks:
            (self._begun / mark).unlink()
        handed = self._handed.values()
        return [s for s in handed if s.key in marks], [s for s in handed if s.key not in marks]

    def _taken(self) -> Iterator[Job]:
        for job in self._jobs:
            self._handed[job.key] = job
            yield job


@contextmanager
def _closed(rans: Generator[Ran, None, None]) -> Iterator[None]:
    """Close what joblib yields; where the sweep ends before its items, joblib would advise another batch size."""
    try:
        yield
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            rans.close()


def _alone(job: Job, begun: Path) -> Ran:
    """Return what comes of an item that has a pool to itself."""
    pool = _Pool(iter([job]), LEAST, begun)
    found = list(pool.rans())
    pool.left()
    return found[0] if found else job.killed()


def _marked(job: Job, begun: str, parent: int) -> Ran:
    """Run an item in a worker; while it runs, a file of its key says so."""
    _follow(parent)
    mark = Path(begun, job.key)
    mark.touch()
    try:
        return job.run()
    finally:
        mark.unlink(missing_ok=True)


#: whether this process looks after the one that began it
_following = threading.Event()


def _follow(parent: int) -> None:
    """End this worker soon after its parent: a sweep that was killed would leave it at its item, and then waiting."""
    if not _following.is_set():
        _following.set()
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)


def _end_workers(*, kill: bool) -> None:
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True, kill_workers=kill)


def _check_installed() -> None:
    try:
        import joblib  # noqa: F401
    except ImportError:
        raise MissingExtra("the engine 'local' needs joblib: pip install 'stretch-bt[sweep]'") from None
