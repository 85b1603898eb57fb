"""What the nodes of a run were made of, to put it back where own code took it away: the safe end needs it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from stretch_bt.errors import NodeError
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.made import base_attributes

__all__ = ["AsBuilt"]


class AsBuilt:
    """The nodes of a tree as they were before the first tick."""

    def __init__(self, tree: BuiltTree) -> None:
        roots = [root for root in (tree.root, tree.finish) if root is not None]
        found = [*tree.nodes.values(), *(node for root in roots for node in root.iterate())]
        nodes = {id(node): node for node in found}
        paths = {id(node): path for path, node in tree.nodes.items()}
        self._nodes = [(node, paths.get(key, node.name), _parts(node)) for key, node in nodes.items()]

    def mend(self) -> list[NodeError]:
        """Put back what nodes lost, and return an error for each of them."""
        found = []
        for node, path, parts in self._nodes:
            wrong = list(_wrong(node, parts))
            for name in wrong:
                vars(node)[name] = _copied(parts[name])
            if wrong:
                found.append(NodeError(path, _told(wrong)))
        return found


def _parts(node: Any) -> dict[str, Any]:
    """Return the attributes of a node, except those that its own code adds.

    A node is asked for each attribute: once its `__dict__` was looked at, Python reads its attributes more slowly, and a tick costs half as
    much again.
    """
    if not isinstance(node, Behavior):
        return {name: _copied(value) for name, value in vars(node).items()}
    known = ((name, getattr(node, name, MISSING)) for name in base_attributes())
    return {name: _copied(value) for name, value in known if value is not MISSING}


def _copied(value: Any) -> Any:
    return list(value) if isinstance(value, list) else value


def _wrong(node: Any, parts: Mapping[str, Any]) -> Iterator[str]:
    """Yield the names of attributes that are gone, and of those that place a node in the tree and are changed."""
    now = vars(node)
    for name in sorted(parts):
        if name not in now or (name in ("children", "path") and now[name] != parts[name]):
            yield name


def _told(wrong: list[str]) -> str:
    more = f" and {len(wrong) - 1} more" if len(wrong) > 1 else ""
    return (
        f"own code took away or changed {wrong[0]!r}{more}, which the run needs; call attributes of your own otherwise"
    )
