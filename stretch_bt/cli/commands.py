"""The commands of a folder: each `command_NAME` file is one, and each folder in it a group of commands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

__all__ = ["Commands", "Group"]


class Commands(Mapping[str, Any]):
    """Commands by name, each imported and made when it is asked for: a run needs one of twenty.

    Parameters
    ----------
    package
        The folder.
    """

    def __init__(self, package: ModuleType) -> None:
        found = sorted(iter_modules(package.__path__), key=lambda module: module.ispkg)
        self._modules = {
            module.name.removeprefix("command_").replace("_", "-"): f"{package.__name__}.{module.name}"
            for module in found
            if module.ispkg or module.name.startswith("command_")
        }

    def __getitem__(self, name: str) -> Any:
        return _made(name, self._modules[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._modules)

    def __len__(self) -> int:
        return len(self._modules)

    def __contains__(self, name: object) -> bool:
        return name in self._modules


class Group(TyperGroup):
    """Commands that are named without being made."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names."""
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, or None where none has that name; an error while one is made is not hidden."""
        if cmd_name not in self.commands:
            return None
        return self.commands[cmd_name]


@cache
def _made(name: str, module: str) -> Any:
    loaded = import_module(module)
    if hasattr(loaded, "__path__"):
        inner: Any = Commands(loaded)
        return Group(name=name, commands=inner, help=loaded.__doc__, no_args_is_help=True)
    alone = typer.Typer(add_completion=False)
    alone.command(name)(loaded.command)
    return get_command(alone)
