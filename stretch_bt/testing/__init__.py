"""For tests of trees and nodes: a scripted device, and the pytest fixtures.

The fixtures are `run`, `tick_task`, `tick_node`, `cell`, `scripted_device` and `virtual_clock`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.testing.scripted import ScriptedDevice as ScriptedDevice

__all__ = ["ScriptedDevice"]


def __getattr__(name: str) -> Any:
    if name != "ScriptedDevice":  # pytest loads this package in every session, so it loads nothing itself
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from stretch_bt.testing.scripted import ScriptedDevice

    return ScriptedDevice
