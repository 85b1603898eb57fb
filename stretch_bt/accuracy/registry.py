"""Which domains there are."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules

from stretch_bt import accuracy
from stretch_bt.accuracy.job import Domain
from stretch_bt.errors import InvalidInput
from stretch_bt.source import closest

__all__ = ["domains", "names"]

_PREFIX = "domain_"


def names() -> list[str]:
    """Return the names of all domains."""
    return sorted(m.name.removeprefix(_PREFIX) for m in iter_modules(accuracy.__path__) if m.name.startswith(_PREFIX))


def domains(chosen: Iterable[str] = ()) -> dict[str, Domain]:
    """Return the named domains, or all, by their names.

    Raises
    ------
    InvalidInput
        A name is not known; the text lists those that are.
    """
    found = names()
    wanted = list(dict.fromkeys(chosen)) or found
    for name in wanted:
        if name not in found:
            near = closest(name, found)
            hint = f"; did you mean {near!r}?" if near else ""
            raise InvalidInput(f"there is no accuracy domain {name!r}; the domains are {', '.join(found)}{hint}")
    return {name: import_module(f"{accuracy.__name__}.{_PREFIX}{name}").DOMAIN for name in wanted}
