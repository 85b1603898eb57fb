"""Files judged each by itself, though one process checks them all."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import ModuleType

from stretch_bt.hardware.own_modules import installed_module
from stretch_bt.tree import registry

__all__ = ["apart"]


@contextmanager
def apart() -> Iterator[None]:
    """Forget at the end the own modules that were imported meanwhile, and their nodes; installed packages stay.

    The next file that names one of these modules imports it again: only so are its nodes known there, and there alone.
    """
    modules, nodes = set(sys.modules), registry.known()
    try:
        yield
    finally:
        is_installed = cache(_is_installed)
        for name in [name for name in sys.modules if name not in modules]:
            if not is_installed(name.partition(".")[0]):
                sys.modules.pop(name, None)
        registry.forget(name for name, info in registry.known().items() if _is_gone(info.cls) and name not in nodes)


def _is_gone(cls: type) -> bool:
    return cls.__module__ not in sys.modules


def _is_installed(top: str) -> bool:
    """Whether a module, or the package that it belongs to, is no own one of a tree or a cell file."""
    module = sys.modules.get(top)
    if not isinstance(module, ModuleType) or module.__spec__ is None or module.__spec__.name != top:
        return True  # made by code, or another name of a part of a package, so that it could not be imported again
    found = installed_module(top)
    return found is not None and found.origin == module.__spec__.origin
