"""A task as a drawing needs it: called trees unfolded in place, every node with its path and its ports as written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from stretch_bt.tree.flow import Call, Leaf, Part
from stretch_bt.tree.flow.guard import Check
from stretch_bt.tree.node_info import first_paragraph
from stretch_bt.tree.paths import Paths
from stretch_bt.tree.program import Program, TreeBody
from stretch_bt.tree.values import written_pairs

__all__ = ["NodeView", "around_text", "kind_of", "views"]


@dataclass(slots=True)
class NodeView:
    """One node of a drawing; `around` are the reserved words beside it, the outermost first, each with its path."""

    title: str
    keyword: str
    kind: str
    path: str
    settings: dict[str, str] = field(default_factory=dict)
    left_out: frozenset[str] = frozenset()  # of the settings: records that the file does not name
    doc: str = ""
    around: list[tuple[str, str]] = field(default_factory=list)
    children: list[NodeView] = field(default_factory=list)
    finish: NodeView | None = None

    def walk(self) -> Iterator[NodeView]:
        """Yield the node and everything under it, in order."""
        yield self
        for child in [*self.children, *([self.finish] if self.finish else [])]:
            yield from child.walk()


def views(program: Program) -> list[NodeView]:
    """Return the main tree, or every tree of a file that has none."""
    trees = program.document.trees
    main = trees.get("main")
    return [
        _tree(program, Paths(), signature.name, program.body(signature))
        for signature in ([main] if main else trees.values())
    ]


def _tree(program: Program, paths: Paths, path: str, body: TreeBody) -> NodeView:
    found = NodeView(body.signature.name, "tree", "tree", path, doc=body.signature.doc or program.document.doc)
    return _fill(program, paths, found, body)


def _fill(program: Program, paths: Paths, view: NodeView, body: TreeBody) -> NodeView:
    if body.signature.own:
        name = "own keys" if "keys" in view.settings else "keys"  # which an input may be called
        view.settings = {**view.settings, name: written_pairs(body.signature.own)}
    view.children = [_view(program, paths, body.part, paths.root(body.part, view.path))]
    if body.finish is not None:
        base = f"{view.path}/finally"
        view.finish = _view(program, paths, body.finish, paths.root(body.finish, base))
    return view


def _view(program: Program, paths: Paths, part: Part, path: str) -> NodeView:
    around = []
    while part.beside:
        around.append((around_text(part), path))
        inner = part.children()[0]
        path = paths.child(part, inner, path)
        part = inner
    left_out = frozenset(part.left_out) if isinstance(part, Leaf | Call) else frozenset()
    found = NodeView(part.label, _keyword(part), kind_of(part), path, part.written(), left_out, _doc(part), around)
    if isinstance(part, Call):
        return _fill(program, paths, found, program.body(part.target))
    found.children = [_view(program, paths, child, paths.child(part, child, path)) for child in part.children()]
    return found


def kind_of(part: Part) -> str:
    """Return the sort of node of a part: `tree`, `flow`, `condition`, `data`, or the kind of its class."""
    if isinstance(part, Leaf):
        return str(part.info.cls.kind)
    if isinstance(part, Call):
        return "tree"
    if part.children():
        return "flow"
    return "condition" if isinstance(part, Check) else "data"


def around_text(part: Part) -> str:
    """Return a reserved word beside a node in one line, such as `timeout 8 s`."""
    given = part.name if part.name and ":" not in part.name else ""
    text = " ".join(part.written().values())
    return f"{part.keyword} {given}: {text}" if given else f"{part.keyword} {text}"


def _keyword(part: Part) -> str:
    if isinstance(part, Leaf):
        return part.info.name
    return part.target.qualified if isinstance(part, Call) else part.keyword


def _doc(part: Part) -> str:
    if isinstance(part, Leaf):
        return part.info.doc
    return first_paragraph(part.target.doc if isinstance(part, Call) else type(part).__doc__)
