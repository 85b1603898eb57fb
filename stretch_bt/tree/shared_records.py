"""Records that nodes keep from one start to the next, where two places have one in common and neither names it."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Mark
from stretch_bt.tree.flow import Leaf
from stretch_bt.tree.tree_body import TreeBody

__all__ = ["shared_records"]


def shared_records(body: TreeBody) -> Iterator[Diagnostic]:
    """Yield a warning where a node goes on from what another place of the same node remembers, and no file says that it shall.

    That is so where both leave out a record that need not be there before, and nothing else in the tree writes it.
    """
    for (node, port, key), marks in _places(body).items():
        if len(marks) < 2 or len(body.writers.get(key, ())) != len(marks):
            continue
        message = f"{node!r} goes on from ${key} of line {marks[0].line}: both places leave {port!r} out"
        hint = f"write '{node}: {{{port}}}' if it shall, or give it a key of its own: '{port}: $other'"
        yield marks[1].warning("record-shared", message, hint)


def _places(body: TreeBody) -> dict[tuple[str, str, str], list[Mark]]:
    """Return the places of each node that leave a record out which it can begin without, by node, port and key."""
    found: dict[tuple[str, str, str], list[Mark]] = {}
    for leaf in body.parts():
        if not isinstance(leaf, Leaf):
            continue
        for port in leaf.left_out & leaf.inouts.keys():
            if not leaf.info.ports[port].required:
                found.setdefault((leaf.info.name, port, leaf.inouts[port][0]), []).append(leaf.mark)
    return found
