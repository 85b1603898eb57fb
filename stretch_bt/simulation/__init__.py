"""The digital twin: its scenes, how membrane and object meet, and the camera's view of them."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.press import PressResult as PressResult
    from stretch_bt.simulation.membrane.press import press as press

_HOMES = {"PressResult": "membrane.press", "press": "membrane.press"}
__all__ = [  # noqa: PLE0604
    *_HOMES,
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
