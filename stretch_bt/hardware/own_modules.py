"""Where the Python modules, and the classes in them, that a tree or a cell file names may stand, and their import.

A module is executed when it is imported. A file may come from anybody, so it can name only what is installed already,
or what lies beside the file that the user named: whoever names that file chose its folder too.
"""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from contextvars import ContextVar
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from stretch_bt.blame import place_of
from stretch_bt.errors import StretchError, named, writable
from stretch_bt.forked import alone
from stretch_bt.hardware.imported_texts import note_imported
from stretch_bt.hardware.isolated import trusted_path
from stretch_bt.source import did_you_mean
from stretch_bt.threads_heard import threads_heard

__all__ = ["ModuleRefused", "Modules", "attribute", "brought_for", "installed_module", "standing_for"]

#: names of the modules that were executed for files, installed ones too, by what files import them for, as in `Modules.holds`
_brought: dict[str, set[str]] = {}


#: places of modules that copies stand for, and of folders on Python's path that lead to them
_originals: ContextVar[frozenset[str]] = ContextVar("_originals", default=frozenset())


@contextmanager
def standing_for(originals: frozenset[str]) -> Iterator[None]:
    """Let files whose modules are copies meet none of the originals.

    Whoever starts Python beside a tree has the originals on its path, where they would count as installed modules of the
    same name.

    Parameters
    ----------
    originals
        Absolute paths: of the originals, and of the folders on Python's path that hold them.
    """
    token = _originals.set(originals)
    try:
        yield
    finally:
        _originals.reset(token)


def brought_for(holds: str) -> frozenset[str]:
    """Return the names of all modules that files brought so far for what `Modules.holds` says, installed ones too."""
    return frozenset(_brought.get(holds, ()))


class ModuleRefused(StretchError):
    """A module may not be imported, or cannot be; the text says why, `hint` what to do."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Modules:
    """The folders in which the own modules of a tree or a cell file may stand.

    Parameters
    ----------
    root
        Folder of the file that the user named. Files that it imports may bring modules from folders below it.
    home
        Folder that takes the place of `root` for modules, or None where only installed ones may be imported.
    hint
        What a user can do about a module that is not found.
    say
        Told of each file in these folders before it is executed.
    what
        What names the modules, for messages: `tree` or `cell file`.
    holds
        What a module is imported for, for messages.
    """

    root: Path
    home: Path | None
    hint: str = ""
    say: Callable[[str], None] | None = None
    what: str = "tree"
    holds: str = "nodes"

    @staticmethod
    def beside(file: Path, what: str = "tree", holds: str = "nodes") -> Modules:
        """Return the rule for a file that the user named."""
        folder = file.parent.resolve()
        return Modules(folder, folder, what=what, holds=holds)

    def bring(self, name: str, file: Path) -> ModuleType | type:
        """Import a module that a file names, or one with a class that it names, and return it.

        The part of a name that names a module is found without executing any code.

        Raises
        ------
        ModuleRefused
            It is not installed and not beside the file, it has the name of another module, or it breaks.
        """
        folders = self._folders(file.parent.resolve())
        self._check(name, folders)
        module = longest_module(name, folders)
        try:
            # standard output is the command's alone
            with (
                _path([*_installed_path(), *folders]),
                _told(folders, self.say),
                redirect_stdout(sys.stderr),
                alone(),
                threads_heard(),
                _noted(self.holds),
            ):
                importlib.import_module(module)
                note_imported(folders)
                found = attribute(module, name.removeprefix(module).lstrip("."))
        except ModuleRefused:
            raise
        except (Exception, SystemExit) as error:  # whatever the module of a third party does
            told = writable(error) if isinstance(error, StretchError) else named(error).removesuffix(": ")
            # the text of a SyntaxError has the place
            at = "" if isinstance(error, SyntaxError) else place_of(error) or self._file(name, folders)
            message = f"module {module!r} cannot be imported: {told}{at and f' ({at})'}"
            raise ModuleRefused(message, _mending(error)) from error
        if not isinstance(found, type | ModuleType):
            what = f"{name!r} is neither a module nor a class, but of type {type(found).__name__!r}"
            raise ModuleRefused(what, "name a module, or a class in one")
        return found

    def _folders(self, folder: Path) -> list[str]:
        if self.home is None:
            return []
        below = [self.home / folder.relative_to(self.root)] if folder.is_relative_to(self.root) else []
        return list(dict.fromkeys(str(path) for path in (*below, self.home)))

    def _check(self, name: str, folders: list[str]) -> None:
        top = name.partition(".")[0]
        if not all(part.isidentifier() for part in name.split(".")):
            raise ModuleRefused(
                f"{name!r} is not the name of a Python module", f"write 'own: my_{self.holds}', without .py"
            )
        if "__main__" in name.split("."):
            raise ModuleRefused(
                f"{name!r} is a program, not the name of a Python module with {self.holds}", self._remedy
            )
        installed, own = installed_module(top), PathFinder.find_spec(top, folders)
        if own is None and installed is None and top not in sys.modules:
            raise ModuleRefused(
                f"no Python module {top!r} is installed, and none is beside the {self.what}", self._help(top)
            )
        if own is not None:
            self._check_alone(top, own, installed)

    @staticmethod
    def _file(name: str, folders: list[str]) -> str:
        """Return the file of a module, for an error that came up before any of its lines was executed."""
        found = PathFinder.find_spec(name.partition(".")[0], folders)
        return "" if found is None else _place(found)

    def _help(self, top: str) -> str:
        found = PathFinder.find_spec(top, [""])
        remedy = self._remedy
        return remedy if found is None else f"{_place(found)} in the current folder does not count: {remedy}"

    @property
    def _remedy(self) -> str:
        return self.hint or f"install the package, or put the module beside the {self.what}"

    def _check_alone(self, top: str, own: ModuleSpec, installed: ModuleSpec | None) -> None:
        """Refuse a module beside the file that another module of its name would replace, or be replaced by."""
        loaded = sys.modules.get(top)
        for other in (installed, loaded.__spec__ if loaded is not None else None):
            if other is not None and _place(other) != _place(own):
                raise ModuleRefused(
                    f"module {top!r} beside the {self.what} ({_place(own)}) has the name of another one ({_place(other)})",
                    f"rename the module beside the {self.what}",
                )


#: modules of this package whose names own code imports, the likeliest first
_PUBLIC = tuple(f"stretch_bt.{home}" for home in ("units", "errors", "hardware.interfaces", "perception", "model"))


def _mending(error: BaseException) -> str:
    """Return how to mend a module that cannot be imported; where a name of this package was sought in the wrong place, the right one."""
    sought = re.search(r"cannot import name '(\w+)' from 'stretch_bt\b", str(error))
    for home in _PUBLIC if sought is not None and isinstance(error, ImportError) else ():
        if sought is not None and hasattr(importlib.import_module(home), sought[1]):
            return f"write 'from {home} import {sought[1]}'"
    return "mend the module, or install what it needs"


def longest_module(name: str, folders: Sequence[str]) -> str:
    """Return the part of a dotted name that names a module; no module is executed, and the rest of the name is looked for in it."""
    found, _, rest = name.partition(".")
    with _path([*_installed_path(), *folders]):
        _, places = _located(found, None)
        while rest and places:
            part, _, rest = rest.partition(".")
            is_module, inside = _located(f"{found}.{part}", places)
            if not is_module:
                break
            found, places = f"{found}.{part}", inside
    return found


def _located(module: str, places: Sequence[str] | None) -> tuple[bool, Sequence[str]]:
    """Return whether there is a module in some folders, None for the folders of Python's path, and where a package has its modules."""
    if module in sys.modules:
        return True, list(getattr(sys.modules[module], "__path__", ()))
    try:
        finders = [PathFinder] if places is not None else sys.meta_path
        specs = (finder.find_spec(module, places) for finder in finders)
        spec = next((spec for spec in specs if spec is not None), None)
        return spec is not None, [] if spec is None else list(spec.submodule_search_locations or ())
    except KeyError:  # a folder without __init__.py inside another one, of which Python asks that it is imported
        inner = [Path(place) / module.rpartition(".")[2] for place in places or ()]
        return True, [str(folder) for folder in inner if folder.is_dir()]


def attribute(module: str, name: str) -> Any:
    """Return what a dotted name means in a module that was imported, the module itself for none; raises ModuleRefused."""
    found: Any = sys.modules[module]
    for part in name.split(".") if name else ():
        if not hasattr(found, part):
            owner = getattr(found, "__name__", part)
            known = [known for known in vars(found) if isinstance(getattr(found, known, None), type)]
            hint = did_you_mean(part, known) or "name a module, or a class in one"
            raise ModuleRefused(f"module {owner!r} has no {part!r}", hint)
        found = getattr(found, part)
    return found


def installed_module(top: str) -> ModuleSpec | None:
    """Return the spec of an installed module of this name, found without executing it, or None; the current folder does not count."""
    with _path(_installed_path()):
        found = (finder.find_spec(top, None) for finder in sys.meta_path)
        return next((spec for spec in found if spec is not None and _place(spec) not in _originals.get()), None)


def _installed_path() -> list[str]:
    """Return the folders in which installed modules are found."""
    return [folder for folder in trusted_path() if folder not in _originals.get()]


def _place(spec: ModuleSpec) -> str:
    """Return where a module is: its file, or the first folder of a package without one."""
    return spec.origin or next(iter(spec.submodule_search_locations or ()), spec.name)


class _Teller:
    """A finder that finds nothing, and reports each file in some folders that the next one will find."""

    def __init__(self, folders: list[str], say: Callable[[str], None]) -> None:
        self.folders, self.say = folders, say

    def find_spec(self, name: str, path: Sequence[str] | None = None, target: Any = None) -> None:
        """Report a module."""
        found = PathFinder.find_spec(name, path)
        origin = Path(found.origin) if found is not None and found.origin is not None else None
        if origin is not None and any(origin.is_relative_to(folder) for folder in self.folders):
            self.say(str(origin))


@contextmanager
def _noted(holds: str) -> Iterator[None]:
    """Note which modules are executed meanwhile."""
    before = set(sys.modules)
    try:
        yield
    finally:
        _brought.setdefault(holds, set()).update(sys.modules.keys() - before)


@contextmanager
def _told(folders: list[str], say: Callable[[str], None] | None) -> Iterator[None]:
    if say is None:
        yield
        return
    teller = _Teller(folders, say)
    sys.meta_path.insert(0, teller)
    try:
        yield
    finally:
        sys.meta_path.remove(teller)


@contextmanager
def _path(entries: list[str]) -> Iterator[None]:
    """Let modules be found in these folders alone."""
    before = sys.path[:]
    importlib.invalidate_caches()  # a module may have been written since the folder was last read
    sys.path[:] = entries
    try:
        yield
    finally:
        sys.path[:] = before
