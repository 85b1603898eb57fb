"""Values go from node to node through keys alone: values that nodes leave elsewhere are a cache, and no node remembers an earlier start."""

from collections.abc import Generator
from typing import Any

import py_trees
import pytest

from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.ports import Status
from stretch_bt.tree.program import shipped_trees

QUICK = {
    "touches": "2",
    "touch_frames": "4",
    "sensing_frames": "8",
    "early_settle": "0 s",
    "settle": "0 s",
    "min_hold": "0 s",
}
#: what makes the runs of the slow protocols short
SHORT = {
    "palpate_stiffness": QUICK,
    "characterize": {"trials": "1", "diameters": "[20 mm, 30 mm]", "stretches": "[0 mm, 20 mm]", "depths": "[3 mm]"},
    "contact_sensitivity": {"diameters": "[20 mm, 30 mm]", "stretches": "[0 mm]", "depths": "[9 mm]"},
    "watch_contact": {"duration": "1 s"},
}
#: run by default; the others take longer
QUICKEST = ("watch_contact",)
#: what the framework itself keeps in a node
OWN = frozenset(vars(Behavior("main/any")))


class Forgetful(Onlooker):
    """Drops, before every tick, what nodes left on the context."""

    def __init__(self, context: Any) -> None:
        self.context = context

    def begin_tick(self, tick: int, time: float) -> None:
        self.context.memory.clear()
        self.context.hand.contact_height = None


def made_anew(node: Behavior) -> None:
    """Give a node the attributes of one that was just made."""
    fresh = vars(type(node)(node.path))
    for name in vars(node).keys() - OWN:
        del node.__dict__[name]
    node.__dict__.update({name: value for name, value in fresh.items() if name not in OWN})


@pytest.mark.parametrize(
    "tree", [pytest.param(tree, marks=[pytest.mark.slow] * (tree not in QUICKEST)) for tree in shipped_trees()]
)
def test_what_nodes_leave_beside_the_keys_changes_nothing(run: Any, tree: str, monkeypatch: pytest.MonkeyPatch) -> None:
    params = SHORT.get(tree)
    before = run(tree, params=params)
    tick, starts = Behavior.tick, []

    def ticked(self: Behavior) -> Generator[py_trees.behaviour.Behaviour, None, None]:
        if self.status is not Status.RUNNING:
            made_anew(self)
            starts.append(self.path)
        yield from tick(self)

    monkeypatch.setattr(Behavior, "tick", ticked)
    after = run(tree, params=params, watch=lambda runner: runner.watchers.append(Forgetful(runner.context)))
    assert len(starts) > 20
    assert (after.status, after.reason, after.ticks) == (before.status, before.reason, before.ticks)
    assert after.outputs == before.outputs
