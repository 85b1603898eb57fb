"""The node library: perception, actuation and model nodes, one to a file, found by being here."""

from importlib import import_module
from pkgutil import iter_modules

from stretch_bt.behaviors._motion import MotionBehavior

__all__ = ["MotionBehavior"]

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")
