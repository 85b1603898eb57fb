"""Clock, runner, safe stop, record, replay, mocks and report of a run.

`stretch_bt.run` is the name of this package and, by contract, of the function that runs a tree: the package is callable.
"""

from __future__ import annotations

import sys
from types import ModuleType

TYPE_CHECKING = False  # see stretch_bt/__init__.py
if TYPE_CHECKING:
    from typing import Any


class _CallablePackage(ModuleType):
    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Run a tree; see `stretch_bt.run.task.run`."""
        from stretch_bt.run.task import run

        return run(*args, **kwargs)


sys.modules[__name__].__class__ = _CallablePackage
