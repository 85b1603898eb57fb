"""What nodes look at before a device is opened."""

from __future__ import annotations

from stretch_bt.blame import own_code
from stretch_bt.errors import InvalidInput
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.built_tree import BuiltTree

__all__ = ["prepare_nodes"]


def prepare_nodes(built: BuiltTree) -> None:
    """Let every node of a tree look at what is known before any device is opened.

    Raises
    ------
    InvalidInput
        A node says what cannot work; the text begins with its path.
    NodeError
        The code of a node broke.
    """
    for node in built.nodes.values():
        if isinstance(node, Behavior):
            try:
                with own_code(node.path, "prepare()"):
                    node.prepare()
            except InvalidInput as error:
                error.args = (f"{node.path}: {error}",)
                raise
