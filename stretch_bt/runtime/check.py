"""Checking files of any of the formats, all findings in one pass; opens no device."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout, suppress
from dataclasses import replace
from pathlib import Path

from stretch_bt.arguments import check_arguments
from stretch_bt.errors import Diagnostic, FileError, StretchError, TreeError
from stretch_bt.hardware.hand_file import FORMAT as HAND
from stretch_bt.hardware.hand_file import HandFile
from stretch_bt.runtime import mocks_file
from stretch_bt.runtime.apart import apart
from stretch_bt.runtime.foreign_nodes import kept_blackboard
from stretch_bt.runtime.mocks import check_mocks, tree_of
from stretch_bt.runtime.sweep_check import check_sweep, modules_below, tree_wrong
from stretch_bt.source import (
    Map,
    Scalar,
    Seq,
    Value,
    closest,
    did_you_mean,
    few_suggestions,
    is_nothing,
    load,
    parse,
    read_text,
    told,
    validate,
)
from stretch_bt.tree.document import Document
from stretch_bt.tree.flow import Leaf
from stretch_bt.tree.foreign.node import ForeignNode
from stretch_bt.tree.headings import FORMAT as TREE
from stretch_bt.tree.made import made_at
from stretch_bt.tree.program import Program, find_tree, load_program
from stretch_bt.tree.sweep_file import FORMAT as SWEEP

__all__ = ["check", "check_file"]


def _tree(path: Path) -> list[Diagnostic]:
    program = load_program(path)
    return [*program.diagnostics, *_scene_of(program.document), *_unmade(program), *_unmade_behaviours(program)]


def _unmade(program: Program) -> list[Diagnostic]:
    """Return where a node class makes no node, each class at its first place; what they print goes to standard error."""
    leaves = [leaf for body in program.bodies.values() for leaf in body.parts() if isinstance(leaf, Leaf)]
    found = []
    for leaf in {leaf.info.cls: leaf for leaf in reversed(leaves)}.values():
        try:
            with redirect_stdout(sys.stderr):
                made_at(leaf.info.cls, leaf.label, leaf.mark)
        except TreeError as error:
            found += error.diagnostics
    return found


def _unmade_behaviours(program: Program) -> list[Diagnostic]:
    """Return where the class of a behaviour refuses the arguments that a place gives it."""
    leaves = [leaf for body in program.bodies.values() for leaf in body.parts() if isinstance(leaf, Leaf)]
    found = []
    for leaf in () if program.errors else leaves:
        if issubclass(leaf.info.cls, ForeignNode):
            node = leaf.info.cls(leaf.label)
            node.given = leaf.arguments()
            try:
                with redirect_stdout(sys.stderr), kept_blackboard():
                    node.prepare()
            except StretchError as error:
                found.append(leaf.mark.error("argument", str(error), "give it other arguments, or mend its class"))
    return found


def _scene_of(document: Document) -> list[Diagnostic]:
    """Return what is wrong with the scene that a tree names."""
    if document.scene is None:
        return []
    from stretch_bt.simulation.scene import load_scene

    try:
        load_scene(document.scene_path or "")
    except FileError as error:
        first = error.diagnostics[0]
        unknown = first.code in ("scene-unknown", "file-missing")
        return [document.scene.mark.error(first.code, first.message, first.hint)] if unknown else error.diagnostics
    return []


def _mocks(path: Path) -> list[Diagnostic]:
    found = mocks_file.read_mocks(path, keep=True)
    tree = tree_of(found)
    program = load_program(tree, None, modules_below(path, tree, "mocks file"))
    if program.errors:
        assert found.tree is not None
        return [tree_wrong(found.tree, str(tree), program, "these mocks cannot be checked")]
    try:
        check_mocks(found, program)
    except TreeError as error:
        assert found.tree is not None
        message = error.diagnostics[0].message
        return [found.tree.mark.error("tree-wrong", message, "mend the class of the node, or mock the node")]
    return []


def _sweep(path: Path) -> list[Diagnostic]:
    return check_sweep(path).diagnostics


def _scene(path: Path) -> list[Diagnostic]:
    from stretch_bt.simulation.scene import load_scene

    load_scene(path)
    return []


def _cell(path: Path) -> list[Diagnostic]:
    from stretch_bt.hardware.cell_file import load_cell

    load_cell(path)
    return []


def _hand(path: Path) -> list[Diagnostic]:
    validate(HandFile, load(path, str(path)))
    return []


_CHECKS: dict[str, Callable[[Path], list[Diagnostic]]] = {
    TREE: _tree,
    "stretch-scene/1": _scene,
    "stretch-cell/1": _cell,
    HAND: _hand,
    mocks_file.FORMAT: _mocks,
    SWEEP: _sweep,
}


def check(paths: Iterable[str | Path] | str | Path, *, cell: str | Path | None = None) -> list[Diagnostic]:
    """Return the findings of files, in the order given; the `format` of each says its kind.

    With a cell, trees are also held against its devices and limits.
    """
    if not isinstance(paths, Iterable) or isinstance(paths, str):
        paths = [paths]
    paths = list(paths)
    for path in paths:
        check_arguments(file=path)
    found = [finding for path in paths for finding in check_file(path)]
    return found if cell is None else [*found, *_with_cell(paths, cell, found)]


@few_suggestions()
def check_file(path: str | Path) -> list[Diagnostic]:
    """Return the findings of one file, or of the shipped tree of that name."""
    try:
        with apart():
            return _as_given(_CHECKS[_format(path)](Path(path)), path)
    except FileError as error:
        return _as_given(error.diagnostics, path)


def _as_given(found: Iterable[Diagnostic], path: str | Path) -> list[Diagnostic]:
    """Return findings with the name that the caller gave the file in place of the name that its reader has for it."""
    called = {str(Path(path))}
    with suppress(FileError):
        called.add(find_tree(path)[1])
    return [replace(finding, file=str(path)) if finding.file in called else finding for finding in found]


def _with_cell(paths: Iterable[str | Path], cell: str | Path, found: list[Diagnostic]) -> list[Diagnostic]:
    """Return what trees without errors ask for beyond a cell, or the mistakes of the cell."""
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.runtime.reach import beyond_cell

    try:
        spec = load_cell(cell)
    except FileError as error:
        return [d for d in _as_given(error.diagnostics, cell) if d not in found]
    beyond: list[Diagnostic] = []
    for path in paths:
        if _is_tree(path):
            with apart():
                program = load_program(path)
                if not program.errors and "main" in program.document.trees and not _unmade(program):
                    beyond += _as_given(beyond_cell(program, spec, path), path)
    return beyond


def _is_tree(path: str | Path) -> bool:
    try:
        return _format(path) == TREE
    except FileError:
        return False


def _format(path: str | Path) -> str:
    """Return the format of a file, or of a shipped tree by its name."""
    file, name = find_tree(path)[0], str(path)
    root = parse(read_text(file, name), name)
    if not isinstance(root, Map):
        raise FileError([root.mark.error("yaml-top", "the top level is not a mapping", f"begin with 'format: {TREE}'")])
    value = root.get("format")
    if value is None:
        slip = next((key for key, _ in root if closest(key.text, ["format"]) is not None), None)
        if slip is not None:
            hint = did_you_mean(slip.text, ["format"])
            raise FileError([slip.mark.error("key-unknown", f"unknown key {slip.text!r}", hint)])
        raise FileError([root.mark.error("format-missing", "the file has no 'format'", f"begin with 'format: {TREE}'")])
    if is_nothing(value) or not isinstance(value, Scalar):
        given = "nothing" if is_nothing(value) else told(value)
        what = f"format takes one line of text, not {given}"
        raise FileError([value.mark.error("format-unknown", what, f"write 'format: {_meant(value)}'")])
    if value.text not in _CHECKS:
        hint = did_you_mean(value.text, _CHECKS)
        raise FileError([value.mark.error("format-unknown", f"{value.text!r} is not a format", hint)])
    return value.text


def _meant(value: Value) -> str:
    """Return the format that is the only entry of a list, else the format of a tree."""
    only = value.items[0] if isinstance(value, Seq) and len(value.items) == 1 else None
    return only.text if isinstance(only, Scalar) and only.text in _CHECKS else TREE
