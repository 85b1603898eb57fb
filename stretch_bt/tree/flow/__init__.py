"""The constructs of the tree language, one to a file."""

from stretch_bt.tree.flow import for_each, groups, guard, parallel, repeat, results, set_keys, timeout, until
from stretch_bt.tree.flow.base import CONSTRUCTS, FlowNode, Part, Wire
from stretch_bt.tree.flow.broken import Broken
from stretch_bt.tree.flow.call import Call
from stretch_bt.tree.flow.leaf import Leaf

__all__ = [
    "CONSTRUCTS",
    "Broken",
    "Call",
    "FlowNode",
    "Leaf",
    "Part",
    "Wire",
    "for_each",
    "groups",
    "guard",
    "parallel",
    "repeat",
    "results",
    "set_keys",
    "timeout",
    "until",
]
