"""A task as a whole: every tree of its files read, checked in one pass, and ready to be built."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stretch_bt.errors import Diagnostic, FileError, TreeError
from stretch_bt.hardware.own_modules import Modules
from stretch_bt.source import Map, Mark, closest, did_you_mean, few_suggestions
from stretch_bt.tree import headings, registry
from stretch_bt.tree.dataflow import check_flow
from stretch_bt.tree.document import DeviceDecl, Document, Signature
from stretch_bt.tree.flow import CONSTRUCTS
from stretch_bt.tree.kept_out_records import kept_out_records
from stretch_bt.tree.keys import settle_types
from stretch_bt.tree.known_values import known_values
from stretch_bt.tree.lost_errors import lost_errors
from stretch_bt.tree.reader import Reader
from stretch_bt.tree.registry import RESERVED
from stretch_bt.tree.shared import SHARED, shipped
from stretch_bt.tree.shared_records import shared_records
from stretch_bt.tree.structure import check_structure
from stretch_bt.tree.tree_body import TreeBody

__all__ = ["Program", "TreeBody", "find_tree", "load_program"]


@dataclass(slots=True)
class Program:
    """A task file with everything that it imports; `entry` is the tree that is ticked."""

    document: Document
    bodies: dict[int, TreeBody]
    diagnostics: list[Diagnostic]
    entry: str = "main"

    @property
    def main(self) -> TreeBody:
        """The tree that a run ticks."""
        return self.body(self.document.trees[self.entry])

    def body(self, signature: Signature) -> TreeBody:
        """Return the read body of a tree."""
        return self.bodies[id(signature)]

    @property
    def errors(self) -> list[Diagnostic]:
        """The findings that forbid a run."""
        return [d for d in self.diagnostics if d.severity == "error"]

    def require(self) -> Program:
        """Return self, or raise TreeError with every error."""
        if self.errors:
            raise TreeError(self.errors)
        return self


def shipped_trees() -> list[str]:
    """Return the names of the shipped tasks."""
    return sorted(p.stem for p in shipped("").glob("*.yaml"))


def find_tree(tree: str | Path) -> tuple[Path, str]:
    """Return the path of a tree file, or of the shipped tree of that name, and what messages call it.

    Raises
    ------
    TreeError
        There is neither.
    """
    path = Path(tree)
    if path.suffix in (".yaml", ".yml") or _exists(path):
        return path, str(tree)
    own = shipped(f"{tree}.yaml")
    if own.exists():
        return own, f"{tree}.yaml"
    hint = did_you_mean(str(tree), shipped_trees())
    raise TreeError([Diagnostic(str(tree), 1, 1, "error", "file-missing", "no such file or shipped tree", hint)])


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # no file has such a name
        return False


@few_suggestions()
def load_program(
    tree: str | Path,
    params: Mapping[str, Any] | None = None,
    modules: Modules | None = None,
    *,
    text: str | None = None,
) -> Program:
    """Read and check a tree file; `params` holds what `--set` gives, `modules` where its Python modules may stand.

    `text` is taken for the content of the file.

    Raises
    ------
    TreeError
        The file cannot be read at all; other findings are in `.diagnostics`, all of them at once.
    """
    path, name = find_tree(tree)
    try:
        document = headings.read_document(path, name, params, modules, text)
    except FileError as error:
        raise TreeError(error.diagnostics) from None
    return _Checker(document).run()


class _Checker:
    def __init__(self, document: Document) -> None:
        self.document = document
        self.program = Program(document, {}, [])
        self.found = self.program.diagnostics

    def run(self) -> Program:
        ahead = list(_documents(self.document))
        for document in ahead:  # which grows by the variants that calls ask for
            self.found += document.diagnostics
            self.check_modules(document)
            self.check_classes(document)
            for signature in document.trees.values():
                self.check_names(signature)
                self.read(signature)
            ahead += self.asked_for(ahead)
        self.check_main()
        self.check_flows()
        self.found += check_structure(self.program.bodies, self.document.trees.get("main"))
        self.check_devices()
        self.check_params()
        self.at_calls()
        self.sort()
        return self.program

    def asked_for(self, known: list[Document]) -> list[Document]:
        """Return the files that calls want with other params, and what those import, as far as they are not known."""
        variants = [variant for document in known for variant in document.variants.values()]
        found = [inner for variant in variants for inner in _documents(variant)]
        return [document for document in found if all(document is not other for other in known)]

    def at_calls(self) -> None:
        """Move the mistakes inside a shipped tree to the call of that tree: there they can be mended, as by a device that is missing."""
        for document in _documents(self.document):
            for shared in {id(shared): shared for shared in document.shared.values()}.values():
                inside = [d for d in self.found if d.file == shared.file]
                self.found[:] = [d for d in self.found if d.file != shared.file]
                # one remedy is enough for all that it mends
                self.found += {d.hint: _at_call(d, document, shared) for d in reversed(inside)}.values()

    def sort(self) -> None:
        seen = dict.fromkeys(self.found)
        order = {name: i for i, name in enumerate(["--set", *self.document.files])}
        self.found[:] = sorted(seen, key=lambda d: (order.get(d.file, 99), d.line, d.column))

    def read(self, signature: Signature) -> None:
        self.found += settle_types(signature)
        reader = Reader(signature)
        finish_value = signature.body.get("finally")
        rest = type(signature.body)(
            tuple((k, v) for k, v in signature.body if k.text != "finally"), signature.body.mark
        )
        part = reader.body(rest) if rest.pairs else None
        if not rest.pairs:
            reader.error(
                signature.mark,
                "body-missing",
                f"tree {signature.name!r} has no body",
                "write 'sequence: [...]' under it",
            )
        finish = None if finish_value is None else reader.body(finish_value)
        self.found += reader.diagnostics
        if part is not None:
            body = TreeBody(signature, part, finish)
            for inner in (part, *([finish] if finish else [])):
                for key, who, mark in inner.writes():
                    body.writers.setdefault(key, []).append((who, mark))
            self.program.bodies[id(signature)] = body

    def check_names(self, signature: Signature) -> None:
        """A tree called like a node or a construct would hide it, or be hidden by it, in silence."""
        name = signature.name
        taken = _taken(name) or ("import" if name in signature.document.classes else "")
        path = signature.document.path
        if name in SHARED and (path is None or path.resolve() != shipped(SHARED[name]).resolve()):
            taken = "shipped tree, which needs no import"
        if taken:
            message = f"tree {name!r} has the name of a {taken}"
            self.found.append(signature.mark.error("name", message, f"give it another name, such as 'my_{name}'"))

    def check_modules(self, document: Document) -> None:
        """A node that is called as a construct or a shipped tree is none that a tree could name."""
        nodes = registry.load_all().values() if document.modules else ()
        table = document.root.get("imports")
        for key, _ in table if isinstance(table, Map) else ():
            for info in nodes:
                taken = "shipped tree" if info.name in SHARED else "construct" if _is_construct(info.name) else ""
                if taken and info.cls.__module__ == document.modules.get(key.text):
                    message = f"the node {info.name!r} of {info.cls.__module__} has the name of a {taken}"
                    hint = f"give its class another name, such as My{info.cls.__name__}"
                    self.found.append(key.mark.error("name", message, hint))

    def check_classes(self, document: Document) -> None:
        """An import that makes a class a node would hide a node or a construct of its name, or be hidden by it, as well."""
        table = document.root.get("imports")
        for key, _ in table if isinstance(table, Map) else ():
            name = key.text
            taken = _taken(name) or ("shipped tree" if name in SHARED else "")
            if name in document.classes and taken:
                hint = f"import it under another name, such as 'my_{name}'"
                self.found.append(key.mark.error("name", f"import {name!r} has the name of a {taken}", hint))

    def check_main(self) -> None:
        trees = self.document.trees
        if "main" in trees or not trees or any(t.ins or t.outs for t in trees.values()):
            return  # a file without a main whose trees have borders is a library
        meant = closest("main", trees)
        if meant is not None:
            message = f"tree {meant!r} looks like 'main', which is the one that runs and is missing"
            self.found.append(trees[meant].mark.error("main-missing", message, "write 'main'"))
        else:
            message = "no tree is called 'main', so this file can be imported but not run"
            mark = next(iter(trees.values())).mark
            self.found.append(mark.warning("main-missing", message, "call the tree to run 'main'"))

    def check_flows(self) -> None:
        wrong = {d.file for d in self.found if d.severity == "error"}
        for body in self.program.bodies.values():
            extras = [body.finish] if body.finish else []
            understood = body.signature.document.file not in wrong
            self.found += check_flow(body.signature, body.part, extras, body.writers, understood=understood)
            self.found += (*lost_errors(body), *shared_records(body), *known_values(body))
            self.found += kept_out_records(body, self.program.bodies)

    def check_params(self) -> None:
        """Warn of each param that nothing reads, where all was understood."""
        for document in () if self.program.errors else _documents(self.document):
            for param in document.params.values():
                if not param.used:
                    guess = closest(param.name, [name for name in document.params if name != param.name])
                    hint = f"did you mean {guess!r}?" if guess else "remove it, or read it"
                    self.found.append(
                        param.mark.warning("param-unread", f"nothing reads the param {param.name!r}", hint)
                    )

    def check_devices(self) -> None:
        table = self.document.root.get("imports")
        for prefix, imported in self.document.imports.items():
            assert isinstance(table, Map)
            for document in _documents(imported):
                for device in document.devices.values() if document.declares_devices else ():
                    self.check_imported_device(device, document, table.key(prefix).mark)
        for device in self.document.devices.values():
            if not device.used and "main" in self.document.trees:
                message = f"device {device.name!r} is declared but not used"
                self.found.append(device.mark.warning("device-unused", message, "remove it"))

    def check_imported_device(self, device: DeviceDecl, document: Document, mark: Mark) -> None:
        if device.name in self.document.doubtful_devices:
            return
        outer = self.document.devices.get(device.name)
        name = device.interface.__name__
        if outer is None or outer.interface is not device.interface:
            message = f"{document.file} needs a device {device.name!r} of kind {name}, and this file declares "
            message += "none" if outer is None else f"it as {outer.interface.__name__}"
            like = next((d.name for d in self.document.devices.values() if d.interface is device.interface), None)
            hint = f"add 'devices: {{{device.name}: {name}}}'" if outer is None else "rename one of them"
            if outer is None and like is not None:
                hint = f"call {like!r} {device.name!r} here, or leave out 'devices' in {document.file}, which then takes the only one"
            self.found.append(mark.error("device-undeclared", message, hint))
        elif device.used:
            outer.used = True


def _taken(name: str) -> str:
    """Return which kind of thing of the language, or of the registry, has a name already; nothing where it is free."""
    if _is_construct(name):
        return "construct"
    return "node" if registry.lookup(name) else ""


def _is_construct(name: str) -> bool:
    return name in (*CONSTRUCTS, *RESERVED, "run")


def _documents(document: Document) -> Iterator[Document]:
    yield document
    for imported in document.inner:
        yield from _documents(imported)


def _at_call(found: Diagnostic, document: Document, shared: Document) -> Diagnostic:
    """Return a finding inside a shipped tree as one of the place that calls it."""
    begun = [tree for tree in shared.trees.values() if tree.mark.line <= found.line]
    name = max(begun, key=lambda tree: tree.mark.line).name if begun else ""
    name = name if name in document.shared_at else next(iter(document.shared_at))
    mark = document.shared_at[name]
    made = mark.error if found.severity == "error" else mark.warning
    return made(found.code, f"in {name!r}: {found.message}", found.hint)
