"""The kinds of objects that a scene can hold, found in the files of this folder."""

from __future__ import annotations

from functools import lru_cache
from importlib import import_module
from pkgutil import iter_modules
from typing import get_args

from stretch_bt.simulation import objects
from stretch_bt.simulation.objects.base import ObjectSpec

__all__ = ["kinds"]


@lru_cache(maxsize=1)
def kinds() -> dict[str, type[ObjectSpec]]:
    """Return every kind of object by its name in a scene file."""
    found: dict[str, type[ObjectSpec]] = {}
    for module in iter_modules(objects.__path__):
        if module.name == "registry":
            continue
        loaded = import_module(f"{objects.__name__}.{module.name}")
        for made in vars(loaded).values():
            if isinstance(made, type) and issubclass(made, ObjectSpec) and made.__module__ == loaded.__name__:
                for name in get_args(made.model_fields["type"].annotation):
                    found[name] = made
    return dict(sorted(found.items()))
