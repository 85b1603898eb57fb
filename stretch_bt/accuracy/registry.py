"""Which domains there are, and measuring them."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from stretch_bt import accuracy
from stretch_bt.accuracy.points import Row
from stretch_bt.errors import InvalidInput
from stretch_bt.runtime.provenance import processor
from stretch_bt.source import closest

__all__ = ["domains", "measure"]

_PREFIX = "domain_"


def domains(names: Iterable[str] = ()) -> dict[str, ModuleType]:
    """Return the named domains, or all, by their names.

    Raises
    ------
    InvalidInput
        A name is not known; the text lists those that are.
    """
    found = sorted(m.name.removeprefix(_PREFIX) for m in iter_modules(accuracy.__path__) if m.name.startswith(_PREFIX))
    chosen = list(dict.fromkeys(names)) or found
    for name in chosen:
        if name not in found:
            near = closest(name, found)
            hint = f"; did you mean {near!r}?" if near else ""
            raise InvalidInput(f"there is no accuracy domain {name!r}; the domains are {', '.join(found)}{hint}")
    return {name: import_module(f"{accuracy.__name__}.{_PREFIX}{name}") for name in chosen}


def measure(names: Iterable[str] = (), *, quick: bool = False) -> Iterator[Row]:
    """Return the rows of the named domains, or of all, each as soon as it is measured; `quick` takes a small subset."""
    chosen = domains(names)
    return (row for name, domain in chosen.items() for row in _rows(name, domain, quick))


def _rows(name: str, domain: ModuleType, quick: bool) -> Iterator[Row]:
    versions, cpu = _versions(), processor()
    for p in domain.points(quick):
        told = p.case, p.setting, p.seed, p.error, p.error_kind, p.cpu_seconds, p.status
        yield Row(name, *told, versions, cpu, p.robot_seconds)


def _versions() -> dict[str, str]:
    from stretch_bt.runtime.prepare import versions

    return versions("stretch-bt", "numpy", "scipy", "numba") | {"python": platform.python_version()}
