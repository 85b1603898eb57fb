"""One thread for BLAS and LAPACK: on matrices of our size a second one only waits, takes a core for that, and changes the last digits."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

__all__ = ["ONE_THREAD", "kernels", "one_thread"]

#: variables of the environment of another process
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class _Held:
    """Whether this process is held to one thread already."""

    depth = 0


@contextmanager
def one_thread() -> Iterator[None]:
    """Let BLAS and LAPACK run on the calling thread alone; their earlier settings come back afterwards."""
    if _Held.depth:
        yield
        return
    before = [(library, library.num_threads) for library in _libraries()]
    _Held.depth += 1
    try:
        for library, count in before:
            if count != 1:
                library.set_num_threads(1)
        yield
    finally:
        _Held.depth -= 1
        for library, count in before:
            if count != 1:
                library.set_num_threads(count)


def kernels() -> list[str]:
    """Return each BLAS library in use, with the processor that its kernels are for."""
    return sorted(_kernel(library.info()) for library in _libraries())


def _kernel(about: dict[str, Any]) -> str:
    return f"{about['internal_api']} {about['version']} {about.get('architecture') or 'of unknown architecture'}"


@lru_cache(maxsize=1)
def _libraries() -> list[Any]:
    """Return the BLAS libraries of numpy and scipy; found once, because the search takes longer than a press."""
    import numpy  # noqa: F401  only libraries that are loaded can be found
    from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

    _load_scipy_blas()
    return [library for library in ThreadpoolController().lib_controllers if library.user_api == "blas"]


def _load_scipy_blas() -> None:
    """Load the library that scipy brings, which it loads itself later; to import `scipy.linalg` takes longer than most runs."""
    found = find_spec("scipy")
    home = Path(found.origin or "").parent if found is not None else Path()
    brought = [path for folder in (home.parent / "scipy.libs", home / ".dylibs") for path in folder.glob("*openblas*")]
    for path in brought:
        ctypes.CDLL(str(path))
    if not brought:  # it uses one of the system
        import scipy.linalg.lapack  # noqa: F401
