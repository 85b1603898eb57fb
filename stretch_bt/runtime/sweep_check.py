"""A sweep file held against what it names: its trees, their params, its scenes and its cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from stretch_bt.errors import CellError, Diagnostic, FileError, SceneError, StretchError, SweepError, TreeError
from stretch_bt.hardware.own_modules import Modules
from stretch_bt.runtime.apart import apart, brought
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.reach import check_devices
from stretch_bt.source import Scalar, Value, did_you_mean
from stretch_bt.tree.build import build
from stretch_bt.tree.document import Document, Param
from stretch_bt.tree.program import Program, load_program
from stretch_bt.tree.renamed import renamed
from stretch_bt.tree.sweep_file import SweepFile, read_sweep
from stretch_bt.tree.types import BOOL, FLOAT, Type
from stretch_bt.tree.values import ValueRefused, check_bounds, literal, written

__all__ = ["CheckedSweep", "check_sweep", "modules_below", "tree_wrong"]

#: mistakes in the name of a file rather than in its content
_NO_FILE = ("file-missing", "file-folder", "scene-unknown", "cell-unknown")


@dataclass(frozen=True, slots=True)
class CheckedSweep:
    """A sweep file and the trees that it runs, by what it calls them; `diagnostics` holds every mistake."""

    file: SweepFile
    programs: dict[str, Program]
    diagnostics: list[Diagnostic]

    def require(self) -> CheckedSweep:
        """Return self, or raise SweepError with every error."""
        errors = [d for d in self.diagnostics if d.severity == "error"]
        if errors:
            raise SweepError(errors)
        return self


def check_sweep(path: str | Path) -> CheckedSweep:
    """Read a sweep file and all that it names; opens no device.

    Raises
    ------
    SweepError
        Nothing of the sweep file can be read; all other mistakes, in the files that it names too, are in `diagnostics`.
    """
    file, wrong = read_sweep(path)
    found = CheckedSweep(file, {}, wrong)
    for name in found.file.trees:
        found.diagnostics.extend(_tree(found, name))
    for name in found.file.scenes:
        found.diagnostics.extend(_scene(found.file, name))
    found.diagnostics.extend(_cell(found))
    return found


def modules_below(file: Path, tree: str | Path, what: str) -> Modules:
    """Return where the modules of a tree may stand that a file names, not the user: beside the tree, in the folder of the file or below it."""
    home, folder = Path(tree).parent.resolve(), file.parent.resolve()
    if home.is_relative_to(folder):
        return Modules(home, home)
    return Modules(folder, None, f"put the {what} beside the tree, so that you name its folder")


def tree_wrong(name: Scalar, tree: str, program: Program, what: str) -> Diagnostic:
    """Return the error at the name of a tree that has errors, so that nothing that rests on it can be checked."""
    if (first := program.errors[0]).code == "import":
        return name.mark.error("tree-wrong", f"in its tree, {first.message}", first.hint)
    message = f"the tree {name.text!r} has {len(program.errors)} errors, so {what}"
    return name.mark.error("tree-wrong", message, f"see `stretch-bt check {tree}`")


def _load(file: SweepFile, name: Scalar) -> Program:
    tree = file.place(name)
    return load_program(tree, None, modules_below(file.path, tree, "sweep file"))


def _loaded(file: SweepFile, name: Scalar) -> Program:
    """Return a tree of a sweep, the wrong one that it is by itself where it is right with the nodes of modules that others brought."""
    others = brought()
    program = _load(file, name)
    if not others or program.errors:
        return program
    with apart():
        alone = _load(file, name)
    return alone if alone.errors else program


def _tree(found: CheckedSweep, name: Scalar) -> Iterator[Diagnostic]:
    file = found.file
    tree = file.place(name)
    try:
        program = _loaded(file, name)
    except TreeError as error:
        first = error.diagnostics[0]
        yield name.mark.error(first.code, first.message, first.hint)
        return
    if program.errors:
        yield tree_wrong(name, tree, program, "this sweep cannot be checked")
        return
    document = program.document
    if "main" not in document.trees:
        yield name.mark.error("main-missing", f"{name.text!r} has no tree 'main'", "name a tree that can be run")
        return
    found.programs[name.text] = program
    own = document.scene is not None and file.cell is None  # as for a run, a cell that is named takes no tree's scene
    if document.devices and not file.scenes and not own:
        yield name.mark.error("key-missing", f"no scene is named for {name.text!r}", "add 'scene: water_balloon'")
    for param in file.choices:
        yield from _values(file, document, param)


def _same_numbers(values: Sequence[Value], type_: Type, name: str) -> Iterator[Diagnostic]:
    """Yield each number without a unit, or truth, that is another one written otherwise; those with one are told by their text."""
    seen: dict[float, Value] = {}
    for value in values if type_ in (FLOAT, BOOL) else ():
        with suppress(ValueRefused):
            number = float(literal(value, type_, name))
            before = seen.setdefault(number, value)
            if before is not value and written(before) != written(value):
                what = f"{name} has {written(before)!r} and {written(value)!r}, which are the same"
                yield value.mark.error("value", what, "write each value once")


def _values(file: SweepFile, document: Document, name: str) -> Iterator[Diagnostic]:
    """Yield what is wrong with the values of a param for one tree."""
    param = _param(document, name)
    if param is None:
        known = [*document.params, *(f"{p}.{n}" for p, d in document.imports.items() for n in d.params)]
        now = renamed(Path(document.file).stem, name)
        hint = f"it is called {now!r} now" if now else did_you_mean(name, known)
        message = f"the tree {Path(document.file).stem!r} has no param {name!r}"
        yield file.marks[name].error("param-unknown", message, hint)
        return
    for value in file.choices[name]:
        try:
            check_bounds(literal(value, param.type, name), param.type, param.min, param.max, value.mark, name)
        except ValueRefused as refused:
            yield refused.diagnostic
    yield from _same_numbers(file.choices[name], param.type, name)


def _param(document: Document, name: str) -> Param | None:
    """Return a param of a file, `lib.k` of one that it imports as `lib`."""
    prefix, _, rest = name.partition(".")
    if rest and prefix in document.imports:
        return _param(document.imports[prefix], rest)
    return document.params.get(name)


def _scene(file: SweepFile, name: Scalar) -> Iterator[Diagnostic]:
    from stretch_bt.simulation.scene import load_scene

    try:
        load_scene(file.place(name))
    except SceneError as error:
        yield from _at_name(name, error)


def _cell(found: CheckedSweep) -> Iterator[Diagnostic]:
    """Yield the mistakes of the cell: one that is not simulated through and through would move."""
    name = found.file.cell
    if name is None:
        return
    from stretch_bt.hardware.cell_file import load_cell

    try:
        spec = load_cell(found.file.place(name))
    except CellError as error:
        yield from _at_name(name, error)
        return
    real = [device for device, one in spec.devices.items() if not one.implementation.cls.simulated]
    if real:
        message = f"{', '.join(map(repr, real))} of this cell are not simulated; a sweep runs simulated cells alone"
        yield name.mark.error("value", message, "name a cell whose devices all have 'use: simulated'")
    for tree, program in found.programs.items():
        try:
            check_devices(program, spec, build(program, RunContext()).needed())
        except StretchError as error:
            yield name.mark.error(
                "device-missing", f"{tree}: {_first(error)}", "name a cell with the devices of the tree"
            )


def _first(error: StretchError) -> str:
    return error.diagnostics[0].message if isinstance(error, FileError) else str(error)


def _at_name(name: Scalar, error: FileError) -> list[Diagnostic]:
    """Return the mistakes of a file: at its name where there is no file, else at their own places."""
    first = error.diagnostics[0]
    return [name.mark.error(first.code, first.message, first.hint)] if first.code in _NO_FILE else error.diagnostics
