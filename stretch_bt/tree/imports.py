"""What a tree file imports: other files of trees, modules and classes; and the shipped trees that need no import."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any, Protocol

from stretch_bt.errors import FileError
from stretch_bt.hardware.own_modules import ModuleRefused, Modules
from stretch_bt.source import Scalar, Value, closest
from stretch_bt.tree import registry
from stretch_bt.tree.document import Document
from stretch_bt.tree.foreign.of_class import info_of
from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.heading_reader import HeadingReader
from stretch_bt.tree.shared import SHARED, reachable, shared_trees, shipped

__all__ = ["MAX_FILES", "Imports"]

MAX_FILES = 100


class ReadFile(Protocol):
    """Reads a file that another one imports."""

    def __call__(self, path: Path, name: str, overrides: dict[str, Any], prefix: str) -> Document:
        """Return it read; `name` is what messages call it. Raises FileError when nothing of it can be read."""
        ...


class Imports(HeadingReader):
    """Reads what a file imports.

    Parameters
    ----------
    doc
        The file.
    overrides
        Values of params; the params of imported files as `name.param`.
    stack
        The files that are being read, the outermost first.
    count
        Number of the files imported so far, by all of them together.
    modules
        Where modules may stand.
    read
        Reads another file.
    """

    def __init__(
        self,
        doc: Document,
        overrides: Mapping[str, Any],
        stack: tuple[Path, ...],
        count: list[int],
        modules: Modules,
        read: ReadFile,
    ) -> None:
        super().__init__(doc)
        self._overrides = overrides
        self._stack = stack
        self._count = count
        self._modules = modules
        self._read = read

    def read(self, value: Value | None) -> None:
        """Read the heading."""
        for key, target in self.entries(value, "imports"):
            found = len(self.doc.diagnostics)
            if not isinstance(target, Scalar) or not target.text:
                self.error(target.mark, "import", f"{key.text} names no file or module", "write 'name: lib/file.yaml'")
            elif target.text.endswith((".yaml", ".yml")):
                if self.good_name(key, "import"):
                    self._trees(key, target)
            else:
                self._python(key, target)
            if len(self.doc.diagnostics) > found and key.text not in self.doc.imports:
                self.doc.doubtful.add(key.text)

    def shared(self) -> None:
        """Read the shipped trees that the trees of this file call without an import."""
        called = shared_trees(tree.body for tree in self.doc.trees.values())
        self.doc.shared_at = {name: mark for name, mark in called.items() if name not in self.doc.trees}
        for file in sorted({SHARED[name] for name in self.doc.shared_at}):
            found = self._read(shipped(file), file, {}, "")
            wanted = reachable({name: tree.body for name, tree in found.trees.items()}, self.doc.shared_at)
            found.trees = {name: tree for name, tree in found.trees.items() if name in wanted}
            self.doc.shared |= {name: found for name in self.doc.shared_at if name in wanted}
            self.doc.files.update(found.files)

    def _trees(self, key: Scalar, target: Scalar) -> None:
        base = self.doc.path.parent if self.doc.path else Path()
        beside, known = base / target.text, shipped(target.text)
        path = known if known.exists() and not beside.exists() else beside
        name = target.text if path is known else str(Path(self.doc.file).parent / target.text)
        if path.resolve() in self._stack:
            self.error(target.mark, "recursion", f"{target.text} imports itself", "move what both need to a third file")
            return
        self._count[0] += 1
        if self._count[0] > MAX_FILES:
            self.error(target.mark, "import", f"more than {MAX_FILES} files are imported", "import each file once")
            return
        inner = {k.partition(".")[2]: v for k, v in self._overrides.items() if k.startswith(f"{key.text}.")}

        def read(given: dict[str, Any]) -> Document:
            return self._read(path, name, inner | given, f"{self.doc.prefix}{key.text}.")

        try:
            document = read({})
        except FileError as error:
            self.doc.diagnostics += error.diagnostics
            if error.diagnostics[0].code == "file-missing":
                message = f"no file {target.text!r} beside this one, nor among the shipped trees"
                self.doc.diagnostics[-1:] = [target.mark.error("import", message, _nearby(target.text, base))]
            return
        document.reread = read
        self.doc.imports[key.text] = document
        self.doc.files.update(document.files)

    def _python(self, key: Scalar, target: Scalar) -> None:
        """Import a module for its nodes, or a class of behaviours, which is a node by the name of the import."""
        if target.text.endswith(".py"):
            module = target.text.removesuffix(".py").removeprefix("./").replace("/", ".")
            self.error(target.mark, "import", "a module is imported by its name, not by its file", f"write {module!r}")
            return
        self.doc.modules[key.text] = target.text
        try:
            registry.load_all()  # whose names an own node may not take
            found = self._modules.bring(target.text, self.doc.path or Path("tree.yaml"))
            if isinstance(found, type) and self.good_name(key, "node"):
                self.doc.classes[key.text] = info_of(found, key.text)
        except (ModuleRefused, BehaviourRefused) as refused:
            self.error(target.mark, "import", str(refused), refused.hint)


def _nearby(target: str, base: Path) -> str:
    """Return a hint with the file that the name of an import resembles."""
    folder = (base / target).parent
    present = [str(Path(target).parent / p.name) for p in islice(folder.glob("*.y*ml"), 100)]
    known = [str(p.relative_to(shipped(""))) for p in islice(shipped("lib").glob("*.yaml"), 100)]
    guess = closest(target, [*present, *known])
    return f"did you mean {guess!r}?" if guess else "check the path, which is relative to this file"
