"""Compilation of kernels by numba, kept between runs; importing this imports numba, so only kernels do.

A kernel with a signature is compiled, or loaded, when its module is imported, so that no press pays for it. Compiled code is
kept in the user's cache folder, or in the folder that the environment variable NUMBA_CACHE_DIR names; where neither can be
written it is compiled anew each time.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import njit

__all__ = ["cache_folder", "kernel"]

_CONFIG: Any = numba.config
F = TypeVar("F", bound=Callable[..., Any])


def kernel(signature: str | list[str] | None = None) -> Callable[[F], F]:
    """Return a decorator that compiles a function, at once where signatures are given, and keeps the code.

    No product is fused with a sum, and no sum taken in another order, so that each processor gives the same digits; not a
    number and infinity keep their meaning.
    """
    folder = cache_folder()
    options: dict[str, Any] = {"cache": folder is not None, "fastmath": False, "error_model": "numpy"}
    compiled: Any = njit(**options) if signature is None else njit(signature, **options)

    def compile_kept(function: Any) -> Any:
        with _kept_in(folder):
            return compiled(function)

    return compile_kept


@lru_cache(maxsize=1)
def cache_folder() -> Path | None:
    """Return where compiled kernels are kept, None where nothing can be written.

    The folder has the name of what all kernels together say: numba looks at a kernel's own file only, and would go on with
    code into which an older version of another file is built.
    """
    base = Path(_CONFIG.CACHE_DIR or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = base / "stretch-bt" / _fingerprint()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _fingerprint() -> str:
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(Path(__file__).parent.rglob("*_kernel.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@contextmanager
def _kept_in(folder: Path | None) -> Iterator[None]:
    """Let numba keep in a folder the code that it compiles meanwhile."""
    before = _CONFIG.CACHE_DIR
    _CONFIG.CACHE_DIR = "" if folder is None else str(folder)
    try:
        yield
    finally:
        _CONFIG.CACHE_DIR = before
