"""The effects of a scene that are on."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeVar

from stretch_bt.simulation.effects.base import Effect

__all__ = ["Active"]

E = TypeVar("E", bound=Effect)


class Active:
    """Effects by name, in the order in which they are applied; one that is off is not in it, and was never made."""

    def __init__(self, effects: Iterable[Effect] = ()) -> None:
        self._effects = {effect.name: effect for effect in effects}

    def __contains__(self, name: str) -> bool:
        return name in self._effects

    def __iter__(self) -> Iterator[Effect]:
        return iter(self._effects.values())

    def get(self, name: str) -> Effect | None:
        """Return the effect of this name where it is on."""
        return self._effects.get(name)

    def of(self, kind: type[E]) -> list[E]:
        """Return the effects of a group, by its base class."""
        return [effect for effect in self._effects.values() if isinstance(effect, kind)]
