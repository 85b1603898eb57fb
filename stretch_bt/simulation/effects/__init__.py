"""The effects that a scene can switch on, found in the files of this folder."""

from __future__ import annotations

from functools import lru_cache
from importlib import import_module
from pkgutil import iter_modules

from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.effects.base import (
    CameraEffect,
    Effect,
    Exposure,
    MembraneEffect,
    ObjectEffect,
    Parameters,
    RobotEffect,
    Size,
)

__all__ = [
    "Active",
    "CameraEffect",
    "Effect",
    "Exposure",
    "MembraneEffect",
    "ObjectEffect",
    "Parameters",
    "RobotEffect",
    "Size",
    "registry",
]

_GROUPS = ("membrane", "object", "camera", "robot")


@lru_cache(maxsize=1)
def registry() -> dict[str, type[Effect]]:
    """Return every effect by its name: by group, then in the order in which they are applied."""
    found: list[type[Effect]] = []
    for module in iter_modules(__path__):
        loaded = import_module(f"{__name__}.{module.name}")
        found += [
            made
            for made in vars(loaded).values()
            if isinstance(made, type)
            and issubclass(made, Effect)
            and made.__module__ == loaded.__name__
            and "name" in vars(made)
        ]
    return {e.name: e for e in sorted(found, key=lambda e: (_GROUPS.index(e.group), e.order, e.name))}
