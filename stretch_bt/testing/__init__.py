"""For tests of trees, nodes and drivers: a scripted device, the contract of devices, and the pytest fixtures.

The fixtures are `run`, `tick_task`, `tick_node`, `cell`, `scripted_device` and `virtual_clock`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.testing.contract import device_contract as device_contract
    from stretch_bt.testing.scripted import ScriptedDevice as ScriptedDevice

__all__ = ["ScriptedDevice", "device_contract"]

_HOMES = {"ScriptedDevice": "scripted", "device_contract": "contract"}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:  # pytest loads this package in every session, so it loads nothing itself
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
