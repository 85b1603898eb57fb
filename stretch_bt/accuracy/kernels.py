"""Loading compiled code before anything is timed."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages

import stretch_bt

__all__ = ["load_kernels"]

_KERNEL = "_kernel"  # end of the name of a module with compiled code


def load_kernels(*packages: str) -> None:
    """Import all modules with compiled code of some packages, such as `perception`, which compiles it where it is not kept yet."""
    for package in packages:
        found = import_module(f"{stretch_bt.__name__}.{package}")
        for module in walk_packages(found.__path__, f"{found.__name__}."):
            if module.name.endswith(_KERNEL):
                import_module(module.name)
