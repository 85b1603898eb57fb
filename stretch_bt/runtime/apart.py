"""Files judged each by itself, though one process checks them all."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import spec_from_loader
from pathlib import Path
from types import ModuleType

from stretch_bt.hardware.own_modules import installed_module
from stretch_bt.tree import registry
from stretch_bt.tree.node_info import NodeInfo

__all__ = ["apart"]


@contextmanager
def apart() -> Iterator[None]:
    """Forget at the end the own modules that were imported meanwhile, and their nodes; installed packages stay.

    Whoever names one of these modules next gets it as it was, unless its file has changed: executed again it would register
    its classes a second time wherever it does.
    """
    before = set(sys.modules)
    try:
        yield
    finally:
        is_installed = cache(_is_installed)
        own = [name for name in sys.modules if name not in before and not is_installed(name.partition(".")[0])]
        nodes = [info for info in registry.known().values() if info.cls.__module__ in own]
        for name in own:
            _set_aside(name, tuple(info for info in nodes if info.cls.__module__ == name))
        registry.forget(info.name for info in nodes)


@dataclass(frozen=True, slots=True)
class _Aside:
    """A module that was imported for a file that is judged no more, with the time at which its file was written, and its nodes."""

    module: ModuleType
    spec: ModuleSpec
    written: int
    nodes: tuple[NodeInfo, ...]


_aside: dict[str, _Aside] = {}


def _set_aside(name: str, nodes: tuple[NodeInfo, ...]) -> None:
    module = sys.modules.pop(name)
    spec = getattr(module, "__spec__", None)
    if isinstance(spec, ModuleSpec) and spec.origin is not None:
        _aside[name] = _Aside(module, spec, _written(spec.origin), nodes)
        if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
            sys.meta_path.insert(0, _Finder())


def _written(file: str) -> int:
    path = Path(file)
    return path.stat().st_mtime_ns if path.is_file() else 0


class _Finder(MetaPathFinder, Loader):
    """Finds modules that were set aside, where an import finds the file that they were executed from."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how to bring a module back, or None for any other."""
        kept = _aside.get(name)
        found = PathFinder.find_spec(name, path) if kept is not None else None
        if (
            kept is None
            or found is None
            or found.origin != kept.spec.origin
            or _written(found.origin or "") != kept.written
        ):
            return None
        return spec_from_loader(
            name, self, origin=found.origin, is_package=found.submodule_search_locations is not None
        )

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return the module as it was."""
        return _aside[spec.name].module

    def exec_module(self, module: ModuleType) -> None:
        """Make its nodes known again, and bring back the modules that it took anything from."""
        kept = _aside[module.__name__]
        module.__spec__ = kept.spec
        registry.take_again(kept.nodes)
        for value in list(vars(module).values()):
            name = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
            if isinstance(name, str) and name in _aside and name not in sys.modules:
                importlib.import_module(name)


def _is_installed(top: str) -> bool:
    """Whether a module, or the package that it belongs to, is no own one of a tree or a cell file."""
    module = sys.modules.get(top)
    if not isinstance(module, ModuleType) or module.__spec__ is None or module.__spec__.name != top:
        return True  # made by code, or another name of a part of a package, so that it could not be imported again
    found = installed_module(top)
    return found is not None and found.origin == module.__spec__.origin
