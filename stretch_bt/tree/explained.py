"""A condition that can say which values it saw when it was last asked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stretch_bt.quantity_text import format_quantity
from stretch_bt.tree.expression import Environment, Expression, Scope, bind, names
from stretch_bt.tree.expression.parse import Name
from stretch_bt.tree.expression.typecheck import follow
from stretch_bt.tree.types import Type

__all__ = ["Explained"]


#: entries of a list that are written out
_MOST = 20


class Explained:
    """Reads each name once and notes its value: a second reading of a device may differ from the one that decided."""

    def __init__(self, expression: Expression, environment: Environment, scope: Scope) -> None:
        self._seen: dict[str, tuple[Any, Type]] = {}
        self._reads: dict[tuple[str, ...], Callable[[], Any]] = {}
        for name in names(expression):
            symbol = scope.resolve(name.parts)
            type_ = follow(name, symbol.type, symbol.used)
            self._reads[name.parts] = self._noting(name, bind(name, environment), type_)
        self._ask = bind(expression, self)

    def source(self, parts: tuple[str, ...]) -> tuple[Callable[[], Any], tuple[str, ...]]:
        """Return what reads a whole dotted name."""
        return self._reads[parts], ()

    def holds(self) -> bool:
        """Ask the condition."""
        self._seen.clear()
        return bool(self._ask())

    def shown(self) -> str:
        """Return the values that it saw, written out: `arm.force = 5.2 N, depth = 3 mm`."""
        return ", ".join(f"{text} = {_show(value, type_)}" for text, (value, type_) in self._seen.items())

    def _noting(self, name: Name, read: Callable[[], Any], type_: Type) -> Callable[[], Any]:
        text = ".".join(name.parts)

        def noted() -> Any:
            value = read()
            self._seen[text] = (value, type_)
            return value

        return noted


def _show(value: Any, type_: Type) -> str:
    if type_.item is not None and isinstance(value, list | tuple):
        more = ", ..." if len(value) > _MOST else ""
        return f"[{', '.join(_show(item, type_.item) for item in value[:_MOST])}{more}]"
    return format_quantity(value, type_.dimension) if type_.is_number else str(value)
