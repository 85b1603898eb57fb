"""Ports of nodes that are read and written over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from stretch_bt import Behavior, In, InOut, Out, Status, node, run
from stretch_bt.runtime.check import check
from stretch_bt.tree import registry
from stretch_bt.tree.node_description import describe
from stretch_bt.units import Length

pytestmark = pytest.mark.usefixtures("own_nodes")


@dataclass(frozen=True)
class Tally:
    """How often something was counted."""

    count: int
    last: Length


@dataclass(frozen=True)
class Other:
    """Another record."""

    count: int


@pytest.fixture
def own_nodes() -> Iterator[None]:
    """Register nodes that count, and take them away again."""
    registry.load_all()
    before = dict(registry._nodes)

    @node
    class CountOne(Behavior):
        """Count one more."""

        instant = True
        by: In[Length]
        tally: InOut[Tally | None]

        def update(self) -> Status:
            known = 0 if self.tally is None else self.tally.count
            self.tally = Tally(known + 1, self.by)
            return Status.SUCCESS

    @node
    class CountAgain(Behavior):
        """Count one more of what was counted before."""

        instant = True
        tally: InOut[Tally]

        def update(self) -> Status:
            self.tally = Tally(self.tally.count + 1, self.tally.last)
            return Status.SUCCESS

    @node
    class Idle(Behavior):
        """Look at what was counted, and leave it."""

        instant = True
        tally: InOut[Tally | None]

        def update(self) -> Status:
            return Status.SUCCESS

    @node
    class GiveOther(Behavior):
        """Give another record under the same name."""

        instant = True
        tally: Out[Other]

        def update(self) -> Status:
            self.tally = Other(7)
            return Status.SUCCESS

    yield
    registry._nodes.clear()
    registry._nodes.update(before)


def written(folder: Path, body: str) -> Path:
    file = folder / "task.yaml"
    file.write_text(f"format: stretch-tree/1\ntrees:\n  main:\n{body}", encoding="utf-8")
    return file


def errors(file: Path) -> list[tuple[str, str]]:
    return [(d.code, d.message) for d in check([file]) if d.severity == "error"]


def test_what_is_left_out_is_kept_under_its_own_name_from_pass_to_pass(tmp_path: Path) -> None:
    file = written(tmp_path, "    out: {n: , last: }\n    sequence:\n"
                   "      - repeat: {times: 3, do: {count_one: {by: 2 mm}}}\n"
                   "      - count_again\n      - set: {n: tally.count, last: tally.last}\n")  # fmt: skip
    assert errors(file) == []
    found = run(file)
    assert (found.status, found.outputs["n"]["value"], found.outputs["last"]["value"]) == ("SUCCESS", 4, 2.0)


def test_a_tree_that_is_called_begins_anew_unless_it_lets_the_record_through(tmp_path: Path) -> None:
    calls = "      - repeat: {times: 3, do: {once: {%s}}}\n      - set: {n: %s}\n"
    inner = "  once:\n%s    sequence:\n      - count_one: {by: 1 mm}\n      - set: {m: tally.count}\n"
    fresh = "    out: {n: }\n    sequence:\n" + calls % ("m", "m") + inner % "    out: [m]\n"
    assert run(written(tmp_path, fresh)).outputs["n"]["value"] == 1
    kept = "    out: {n: }\n    sequence:\n" + calls % ("m", "m") + inner % "    inout: [tally]\n    out: [m]\n"
    file = written(tmp_path, kept)
    assert errors(file) == []
    assert run(file).outputs["n"]["value"] == 3


def test_what_must_be_there_before_is_an_error_where_nothing_wrote_it(tmp_path: Path) -> None:
    [(code, message)] = errors(written(tmp_path, "    sequence: [count_again]\n"))
    assert code == "read-before-write"
    assert "tally" in message


def test_a_name_that_is_something_else_takes_no_record(tmp_path: Path) -> None:
    body = "    sequence:\n      - give_other: {tally}\n      - {check: {that: tally.count > 0}}\n      - count_one: {by: 1 mm}\n"
    assert [code for code, _ in errors(written(tmp_path, body))] == ["input-written"]
    [(code, message)] = errors(
        written(
            tmp_path,
            "    sequence: [once]\n  once:\n    in: {tally: {type: Tally, default: none}}\n    sequence: [count_one: {by: 1 mm}]\n",
        )
    )
    assert code == "input-written"
    assert "never written" in message


def test_one_that_leaves_it_leaves_it_none(tmp_path: Path) -> None:
    file = written(
        tmp_path, "    out: {none_yet: }\n    sequence:\n      - idle\n      - set: {none_yet: tally == none}\n"
    )
    assert errors(file) == []
    assert run(file).outputs["none_yet"]["value"] is True


def test_nodes_says_which_ports_are_both() -> None:
    about = describe(registry.load_all()["count_one"])
    assert [(p["name"], p["type"], p["required"]) for p in about["inouts"]] == [("tally", "Tally", False)]
    assert [p["name"] for p in about["inputs"]] == ["by"]


def test_a_tree_may_not_read_what_its_caller_need_not_have(tmp_path: Path) -> None:
    body = "    sequence: [once: {}]\n  once:\n    inout: [tally]\n    sequence:\n      - %s\n      - count_one: {by: 1 mm}\n"
    assert errors(written(tmp_path, body % "idle")) == []
    [(code, message)] = errors(written(tmp_path, body % "check: {that: tally.count > 0}"))
    assert code == "read-before-write"
    assert "tally" in message


#: bodies with two places of one node, and whether check reports that the second goes on from the first
SHARED = {
    "both leave it out": ("[count_one: {by: 1 mm}, count_one: {by: 2 mm}]", True),
    "one names it": ("[count_one: {by: 1 mm}, count_one: {by: 2 mm, tally}]", False),
    "each has its own": ("[count_one: {by: 1 mm}, count_one: {by: 2 mm, tally: $other}]", False),
    "it is cleared between": ("[count_one: {by: 1 mm}, set: {tally: none}, count_one: {by: 2 mm}]", False),
    "one place in a loop": ("[repeat: {times: 2, do: [count_one: {by: 1 mm}]}]", False),
    "another node needs it": ("[count_one: {by: 1 mm}, count_again: {}, count_again: {}]", False),
}


@pytest.mark.parametrize("case", SHARED)
def test_two_places_that_share_what_they_remember_are_told(tmp_path, case):
    body, told = SHARED[case]
    path = tmp_path / "tree.yaml"
    path.write_text(f"format: stretch-tree/1\ntrees: {{main: {{sequence: {body}}}}}\n", encoding="utf-8")
    found = check(path)
    assert [d.code for d in found] == ["record-shared"] * told
    assert all("goes on from $tally of line 2" in d.message for d in found)


@pytest.mark.parametrize("body", ["count_one: {by: 1 mm}", "{sequence: [idle, count_one: {by: 1 mm}]}"])
def test_an_out_begins_without_a_value_at_each_call(tmp_path, body):
    path = tmp_path / "tree.yaml"
    path.write_text(
        "format: stretch-tree/1\ntrees:\n"
        "  main: {out: [n], sequence: [once: {tally: $t}, once: {tally: $t}, set: {n: t.count}]}\n"
        f"  once: {{out: [tally], sequence: [{body}]}}\n"
    )
    assert errors(path) == []
    assert run(path).outputs["n"]["value"] == 1
