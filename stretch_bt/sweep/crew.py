"""The workers of a Dask scheduler, each asked once whether it can run items."""

from __future__ import annotations

from typing import Any

from stretch_bt.errors import InvalidInput, StretchError, named
from stretch_bt.sweep.package_digest import another_package, package_digest

__all__ = ["Crew", "cannot_run"]

#: longest wait for the answers of workers, which import the package for it
PATIENCE = "5 minutes"
#: sent as text, and run by `eval`: a worker without the package breaks on a function of ours, and the scheduler waits for ever
_QUESTION = "__import__('stretch_bt.sweep.package_digest', fromlist=['package_digest']).package_digest()"


class Crew:
    """The workers of a client's scheduler.

    Parameters
    ----------
    client
        A `distributed.Client`.
    ask
        Whether they may lack the package or have another one.
    """

    def __init__(self, client: Any, *, ask: bool) -> None:
        self._client = client
        self._ask = ask
        self._known: set[str] = set()

    def look(self) -> int:
        """Return how many workers there are.

        Raises
        ------
        InvalidInput
            One has more than one thread, or another `stretch_bt`.
        StretchError
            One has none.
        OSError
            The scheduler does not answer.
        """
        threads = dict(self._client.nthreads())
        for address, count in threads.items():
            if count != 1:
                what = f"the worker {address} has {count} threads, and a run takes its process for itself"
                raise InvalidInput(f"{what}; start it with --nthreads 1, and more of them with --nworkers")
        new = [address for address in threads if address not in self._known]
        if self._ask and new:
            for address, answer in self._answers(new).items():
                _check(address, answer)
                self._known.add(address)
        return len(threads)

    def wait(self) -> None:
        """Wait until there is a worker."""
        self._client.wait_for_workers(1)

    def _answers(self, workers: list[str]) -> dict[str, Any]:
        """Return what each worker answers, an error in its place; nothing of one that has left meanwhile."""
        try:
            found = self._client.run(eval, _QUESTION, workers=workers, on_error="return", callback_timeout=PATIENCE)
        except TimeoutError:
            raise cannot_run(f"no answer from {', '.join(workers)} within {PATIENCE}") from None
        return {address: answer for address, answer in found.items() if not isinstance(answer, OSError)}


def cannot_run(why: str) -> StretchError:
    """Return the error of workers on which no item can run."""
    return StretchError(f"the workers cannot run an item ({why}); see that each has stretch-bt installed")


def _check(address: str, answer: Any) -> None:
    if isinstance(answer, Exception):
        raise cannot_run(f"{address}: {named(answer)}")
    if answer != package_digest():
        raise another_package(f"the worker {address}")
