"""Files judged each by itself, though one process checks them all."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import spec_from_loader
from pathlib import Path
from types import ModuleType

from stretch_bt.hardware.imported_texts import digest_of_file, imported_digest
from stretch_bt.hardware.own_modules import brought_for, installed_module
from stretch_bt.tree import registry
from stretch_bt.tree.node_info import NodeInfo

__all__ = ["apart", "brought"]


@contextmanager
def apart() -> Iterator[None]:
    """Hide the own modules that trees brought before, and forget at the end those imported meanwhile; installed packages stay.

    Whoever names one of these modules next gets it as it was, unless its file has changed: executed again it would register
    its classes a second time wherever it does. At the end those that were hidden are there again, for what still runs with them.
    """
    modules = {name: sys.modules[name] for name in brought()}
    nodes = _set_aside(modules)
    before = set(sys.modules)
    try:
        yield
    finally:
        _set_aside(sys.modules.keys() - before)
        sys.modules.update(modules)
        registry.take_again(nodes)


def brought() -> list[str]:
    """Return the names of the own modules, now in the process, that trees brought."""
    return _own(brought_for("nodes") & sys.modules.keys())


@dataclass(frozen=True, slots=True)
class _Aside:
    """A module that was imported for a file that is judged no more, with the digest of the text that it was executed from, and its nodes."""

    module: ModuleType
    spec: ModuleSpec
    digest: str | None
    nodes: tuple[NodeInfo, ...]


_aside: dict[str, _Aside] = {}


def _set_aside(names: Iterable[str]) -> list[NodeInfo]:
    """Take own modules, and their nodes, out of the process, and return the nodes; installed ones stay."""
    own = _own(names)
    nodes = [info for info in registry.known().values() if info.cls.__module__ in own]
    for name in own:
        _take_out(name, tuple(info for info in nodes if info.cls.__module__ == name))
    registry.forget(info.name for info in nodes)
    return nodes


def _own(names: Iterable[str]) -> list[str]:
    is_installed = cache(_is_installed)
    return [name for name in names if not is_installed(name.partition(".")[0])]


def _take_out(name: str, nodes: tuple[NodeInfo, ...]) -> None:
    spec = getattr(sys.modules[name], "__spec__", None)
    if isinstance(spec, ModuleSpec) and spec.origin is not None:
        _aside[name] = _Aside(sys.modules[name], spec, imported_digest(name, Path(spec.origin)), nodes)
        if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
            sys.meta_path.insert(0, _Finder())
    del sys.modules[name]


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
            or digest_of_file(Path(found.origin or "")) != kept.digest
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
