"""The exports of all shipped tasks are loaded and ticked by the real BehaviorTree.CPP 4.

Its Python package registers nodes without ports and no controls: ports of own nodes are left off, and an own control is a Sequence.
"""

import xml.etree.ElementTree as ET

import pytest

from stretch_bt.tree.export import export
from stretch_bt.tree.program import load_program, shipped_trees

cpp = pytest.importorskip("behaviortreepy", reason="BehaviorTree.CPP is among the dev extras on Linux alone")


def without_own_ports(xml):
    """Return an export's trees with own nodes as the package can have them, and their kinds by name."""
    root = ET.fromstring(xml)
    described = root.find("TreeNodesModel")
    kinds = {entry.get("ID"): entry.tag for entry in described if entry.tag != "SubTree"}
    root.remove(described)
    for element in root.iter():
        kind = kinds.get(element.get("ID")) if element.tag != "SubTree" else None
        if kind == "Control":
            element.tag, element.attrib = "Sequence", {}
        elif kind is not None:
            element.attrib = {name: text for name, text in element.attrib.items() if name in ("ID", "name")}
    return root, kinds


@pytest.fixture
def engine():
    """Return a function that has an export loaded: the engine's tree, and the names of the leaves that it ticked, once it did."""

    def load(root, kinds):
        factory, ticked = cpp.BehaviorTreeFactory(), []

        def succeed(node):
            ticked.append(node.name())
            return cpp.NodeStatus.SUCCESS

        for name, kind in kinds.items():
            if kind == "Decorator":
                factory.register_simple_decorator(name, lambda status, _: status)
            elif kind == "Condition":
                factory.register_simple_condition(name, succeed)
            elif kind == "Action":
                factory.register_simple_action(name, succeed)
        factory.register_behavior_tree_from_text(ET.tostring(root, encoding="unicode"))
        return factory.create_tree("main"), ticked

    return load


@pytest.mark.parametrize("name", shipped_trees())
def test_the_engine_loads_and_ticks_every_shipped_task(name, engine):
    root, kinds = without_own_ports(export(load_program(name).require(), "btcpp"))
    tree, ticked = engine(root, kinds)
    assert tree.tick_while_running() == cpp.NodeStatus.SUCCESS
    (main,) = (tree for tree in root.iter("BehaviorTree") if tree.get("ID") == "main")
    first = next(e for e in main.iter() if e.tag in ("Action", "Condition", "SubTree"))
    assert ticked
    assert first.tag == "SubTree" or first.get("name", first.get("ID")) == ticked[0]


def test_the_engine_refuses_a_node_that_the_export_does_not_describe(engine):
    root, kinds = without_own_ports(export(load_program("watch_contact").require(), "btcpp"))
    left_out, _ = kinds.popitem()
    with pytest.raises(Exception, match=f"not recognized: {left_out}"):
        engine(root, kinds)
