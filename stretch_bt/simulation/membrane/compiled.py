"""Compilation of kernels by numba, kept between runs; importing this imports numba, so only kernels do.

A kernel with a signature is compiled, or loaded, when its module is imported, so that no press pays for it. Compiled code
is kept in `__pycache__` beside the kernel, in the user's cache folder where that cannot be written, or in the folder that
the environment variable NUMBA_CACHE_DIR names.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

__all__ = ["kernel"]

F = TypeVar("F", bound=Callable[..., Any])

# not a number and infinity keep their meaning: a collapsed element has infinite energy
_FAST = {"contract", "reassoc", "arcp", "nsz"}


def kernel(signature: str | None = None) -> Callable[[F], F]:
    """Return a decorator that compiles a function, at once where the signature is given, and keeps the code."""
    options: dict[str, Any] = {"cache": True, "fastmath": _FAST, "error_model": "numpy"}
    compiled: Any = njit(**options) if signature is None else njit(signature, **options)
    return lambda function: _typed(compiled(function))


def _typed(dispatcher: Any) -> Any:
    return dispatcher
