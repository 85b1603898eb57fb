"""A node that loses attributes that every node needs is named, and does not keep the run from its safe end."""

from typing import Any, ClassVar

import pytest

from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, In, Status


def clear(node: Any) -> None:
    node.__dict__.clear()


def lose_status(node: Any) -> None:
    del node.status


def lose_children(node: Any) -> None:
    del node.children


def no_children(node: Any) -> None:
    node.children = None


def lose_path(node: Any) -> None:
    del node.path


def other_path(node: Any) -> None:
    node.path = "a file of its own"


def lose_writing(node: Any) -> None:
    del node.unwritten


def lose_message(node: Any) -> None:
    del node.feedback_message


def clear_parent(node: Any) -> None:
    node.parent.__dict__.clear()


WAYS = {
    f.__name__: f
    for f in (
        clear,
        lose_status,
        lose_children,
        no_children,
        lose_path,
        other_path,
        lose_writing,
        lose_message,
        clear_parent,
    )
}


class Loses(Behavior):
    """Loses something in one of its methods."""

    instant: ClassVar[bool] = False
    way: In[str]
    where: In[str] = "update"
    then: In[str] = "RUNNING"

    def _at(self, where: str) -> None:
        if where == self.where:
            WAYS[self.way](self)

    def initialise(self) -> None:
        self.kept = Status[self.then]
        self._at("initialise")

    def update(self) -> Status:
        then = Status[self.then]
        self._at("update")
        return then

    def terminate(self, new_status: Status) -> None:
        self._at("terminate")


@pytest.mark.parametrize("then", ["RUNNING", "SUCCESS", "FAILURE"])
@pytest.mark.parametrize("where", ["initialise", "update", "terminate"])
@pytest.mark.parametrize("way", WAYS)
def test_the_node_is_named_and_the_run_ends_safely(bench: Any, way: str, where: str, then: str) -> None:
    registry.node(Loses)
    devices = bench.Devices()
    outcome = bench.run(
        f"""
        parallel:
          - {{name: b, probe: {{script: RRi}}}}
          - {{name: a, loses: {{way: {way}, where: {where}, then: {then}}}}}
        finally: [{{name: end, probe: {{}}}}]
        """,
        cell=devices,
    )
    told = " ".join([outcome.reason, *outcome.errors])
    if way != "lose_status":  # which a tick writes anew
        assert f"main/{'parallel' if way == 'clear_parent' else 'a'}: own code took away or changed" in told
    assert outcome.status == "ERROR" or outcome.errors or way == "lose_status"
    assert devices.stops >= 1
    assert bench.trace[-2:] == ["end.tick", "end.term(S)"]
    assert "b.term(I)" in bench.trace or way == "clear_parent"


def test_a_node_that_clears_itself_is_told_in_one_sentence(bench: Any) -> None:
    registry.node(Loses)
    outcome = bench.run("sequence: [{name: a, loses: {way: clear}}]\nfinally: [{name: b, loses: {way: clear}}]")
    said = (
        "own code took away or changed 'active' and 19 more, which the run needs; call attributes of your own otherwise"
    )
    assert (outcome.status, outcome.reason) == ("ERROR", f"main/a: {said}")
    assert outcome.errors == [f"finally: main/finally/b: {said}"]
