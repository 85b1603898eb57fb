"""Checking files of any of the formats, all findings in one pass; opens no device."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from stretch_bt.errors import Diagnostic, FileError
from stretch_bt.run import mocks as mocks_files
from stretch_bt.source import Map, Scalar, did_you_mean, parse, read_text
from stretch_bt.tree.headings import FORMAT as TREE
from stretch_bt.tree.program import load_program

__all__ = ["check", "check_file"]


def _tree(path: Path) -> list[Diagnostic]:
    return load_program(path).diagnostics


def _mocks(path: Path) -> list[Diagnostic]:
    found = mocks_files.read_mocks(path)
    program = load_program(mocks_files.tree_of(found))
    if not program.errors:
        mocks_files.check_mocks(found, program)
    return program.errors


def _scene(path: Path) -> list[Diagnostic]:
    from stretch_bt.simulation.scene import load_scene

    load_scene(path)
    return []


def _cell(path: Path) -> list[Diagnostic]:
    from stretch_bt.hardware.cell_file import load_cell

    load_cell(path)
    return []


_CHECKS: dict[str, Callable[[Path], list[Diagnostic]]] = {
    TREE: _tree,
    "stretch-scene/1": _scene,
    "stretch-cell/1": _cell,
    mocks_files.FORMAT: _mocks,
}


def check(paths: Iterable[str | Path] | str | Path) -> list[Diagnostic]:
    """Return the findings of files, in the order given; the first key of each says what it is."""
    if isinstance(paths, str | Path):
        paths = [paths]
    return [finding for path in paths for finding in check_file(path)]


def check_file(path: str | Path) -> list[Diagnostic]:
    """Return the findings of one file."""
    name = str(path)
    try:
        return _CHECKS[_format(Path(path), name)](Path(path))
    except FileError as error:
        return error.diagnostics


def _format(path: Path, name: str) -> str:
    root = parse(read_text(path, name), name)
    if not isinstance(root, Map):
        raise FileError([root.mark.error("yaml-top", "the top level is not a mapping", f"begin with 'format: {TREE}'")])
    value = root.get("format")
    if value is None:
        raise FileError(
            [root.mark.error("format-missing", "the first key is not 'format'", f"begin with 'format: {TREE}'")]
        )
    if not isinstance(value, Scalar) or value.text not in _CHECKS:
        given = value.text if isinstance(value, Scalar) else "this"
        raise FileError(
            [value.mark.error("format-unknown", f"{given!r} is not a format", did_you_mean(given, _CHECKS))]
        )
    return value.text
