"""One thread for LAPACK: on matrices of this size a second one only waits, and makes a press up to ten times slower."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

__all__ = ["one_thread"]


@contextmanager
def one_thread() -> Iterator[None]:
    """Let BLAS and LAPACK run on the calling thread alone; what they were set to before comes back afterwards."""
    before = [(library, library.num_threads) for library in _libraries()]
    try:
        for library, count in before:
            if count != 1:
                library.set_num_threads(1)
        yield
    finally:
        for library, count in before:
            if count != 1:
                library.set_num_threads(count)


@lru_cache(maxsize=1)
def _libraries() -> list[Any]:
    """Return the loaded BLAS libraries; found once, because the search takes longer than a press."""
    import scipy.linalg.lapack  # noqa: F401  only libraries that are loaded can be found
    from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

    return [library for library in ThreadpoolController().lib_controllers if library.user_api == "blas"]
