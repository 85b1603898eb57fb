"""What a call from Python gave."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from stretch_bt.brief import brief
from stretch_bt.source import did_you_mean
from stretch_bt.units import Estimate

__all__ = ["Outputs"]

#: characters of one value in the text of outputs; a cloud would fill screens
LONGEST = 60


class Outputs(Mapping[str, Any]):
    """The outputs of a node or a subtree, as attributes and by name, SI; a number with a deviation has it as `.sd`, an absent output is None."""

    def __init__(self, of: str, values: Mapping[str, Any]) -> None:
        self._of = of
        self._values = dict(values)

    def __getattr__(self, name: str) -> Any:
        values = self.__dict__.get("_values", {})
        if name in values:
            return values[name]
        base = name.removesuffix("_sd")
        if base != name and isinstance(values.get(base), Estimate):
            return values[base].sd
        hint = did_you_mean(name, values) or f"it gives {', '.join(values) or 'nothing'}"
        raise AttributeError(f"{self.__dict__.get('_of', 'this')} gives no {name!r}; {hint}")

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._values]

    def __repr__(self) -> str:
        return f"<{self._of}: {', '.join(f'{name} {_short(value)}' for name, value in self._values.items()) or 'no outputs'}>"


def _short(value: Any) -> str:
    if isinstance(value, Estimate):
        return f"{float(value):.6g} +- {value.sd:.2g}"
    text = brief(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
