"""The Python modules of an item in its process: the copies of the worker, while the item runs, and nothing of them afterwards.

A process may have imported the originals, as where a sweep checks its trees, and copies for another sweep. Each folder
of copies has its own modules and nodes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.own_modules import standing_for
from stretch_bt.tree import registry
from stretch_bt.tree.node_info import NodeInfo

__all__ = ["copies_alone", "refuse_changed"]


@dataclass(slots=True)
class _Away:
    """What was taken out of this process: modules by their names, their nodes, and entries of Python's path."""

    modules: dict[str, ModuleType] = field(default_factory=dict)
    nodes: list[NodeInfo] = field(default_factory=list)
    path: list[str] = field(default_factory=list)


#: by the folder of copies: what items brought from there
_kept: dict[Path, _Away] = {}


@contextmanager
def copies_alone(base: Path, files: Mapping[str, bytes], origin: str, homes: Iterable[str]) -> Iterator[None]:
    """Let an item import the Python modules of a folder of copies, and none of their originals.

    Parameters
    ----------
    base
        Folder of the copies.
    files
        Content of the copies by their paths below it.
    origin
        Folder of the originals, which may be on another machine.
    homes
        Paths of the files among `files` that may have modules beside them.
    """
    modules = {Path(name) for name in files if name.endswith(".py")}
    folders = {home for home in _folders(files, homes) if any(m.is_relative_to(home) for m in modules)}
    places = {m for m in modules if any(m.is_relative_to(home) for home in folders)}
    # a package without an __init__.py is known by its folder
    inner = {p for m in places for p in m.parents if any(home in p.parents for home in folders)}
    originals = {(Path(origin) / place).resolve() for place in places | inner}
    led = {(Path(origin) / folder).resolve() for folder in folders}
    away = _taken_out(originals.__contains__, _names(modules))
    _put_back(_kept.get(base, _Away()))
    try:
        with standing_for(frozenset(map(str, originals | led))):
            yield
    finally:
        _kept[base] = _taken_out(lambda place: place.is_relative_to(base), _names(modules), path=True)
        _put_back(away)


def refuse_changed(files: Mapping[str, bytes]) -> None:
    """Refuse modules that an earlier sweep brought into this process in another text.

    What they registered beyond the nodes would be there twice, and differ.

    Raises
    ------
    InvalidInput
        There is one.
    """
    homes = _of_yaml(files)
    for folder, away in _kept.items():
        for name, module in away.modules.items():
            file, stem = getattr(module, "__file__", None), Path(*name.split("."))
            places = {str(home / end) for home in homes for end in (stem.with_suffix(".py"), stem / "__init__.py")}
            new = [content for path, content in files.items() if path in places]
            if file is None or not new or not Path(file).is_relative_to(folder):
                continue
            if not Path(file).is_file() or Path(file).read_bytes() not in new:
                what = f"this worker has imported another {name.partition('.')[0]!r}, of an earlier sweep"
                raise InvalidInput(f"{what}; restart the workers, and go on with --resume")


def _folders(files: Iterable[str], homes: Iterable[str]) -> set[Path]:
    """Return the folders in which modules may stand: of the files that an item names, and of files below that these may import."""
    found = {Path(home).parent for home in homes}
    return found | {folder for folder in _of_yaml(files) if any(folder.is_relative_to(home) for home in found)}


def _of_yaml(files: Iterable[str]) -> set[Path]:
    """Return the folders of the files that may import modules."""
    return {Path(name).parent for name in files if name.endswith((".yaml", ".yml"))}


def _names(modules: Iterable[Path]) -> set[str]:
    """Return the names that a module of some files, or the outermost package that holds it, may have."""
    return {part for path in modules for part in path.with_suffix("").parts}


def _taken_out(is_one: Callable[[Path], bool], tops: set[str], *, path: bool = False) -> _Away:
    """Take the modules that stand in some places out of this process, and with `path` what leads there."""
    found = _Away()
    for name in [name for name in sys.modules if name.partition(".")[0] in tops]:
        if any(is_one(Path(place).resolve()) for place in _places(sys.modules[name])):
            found.modules[name] = sys.modules.pop(name)
    found.nodes = [info for info in registry.known().values() if info.cls.__module__ in found.modules]
    registry.forget(info.name for info in found.nodes)
    if path:  # what a module has put there would be an installed one of its name for all others
        found.path = [entry for entry in sys.path if entry and is_one(Path(entry).absolute())]
        sys.path[:] = [entry for entry in sys.path if entry not in found.path]
    return found


def _put_back(away: _Away) -> None:
    sys.modules.update(away.modules)
    registry.take_again(away.nodes)
    sys.path[:0] = away.path


def _places(module: ModuleType) -> list[str]:
    """Return the file of a module, and the folders of a package, which may have no file."""
    return [str(place) for place in (getattr(module, "__file__", None), *getattr(module, "__path__", ())) if place]
