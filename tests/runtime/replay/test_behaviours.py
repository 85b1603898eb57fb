"""A replay takes what behaviours of other packages did from the record: they go by the machine's clock, by chance, or by the network."""

import json
import sys

import pytest

from stretch_bt import run
from stretch_bt.errors import RecordError
from stretch_bt.runtime.replay.again import replay

MODULE = '''
import os
import random
import time

import py_trees
from py_trees.common import Status
from py_trees.ports import BehaviourWithPorts, PortInformation

MADE = []


class Chance(BehaviourWithPorts, register=False):
    """Ends by chance after a time of its own, with a number and words by chance."""

    INPUT_PORTS = {"longest": PortInformation(data_type=float, default_value=0.05)}
    OUTPUT_PORTS = {
        "number": PortInformation(data_type=float),
        "words": PortInformation(data_type=list[str], required=False),
    }

    def __init__(self, name: str, breaks: str = ""):
        super().__init__(name=name)
        MADE.append(self)
        self.breaks = breaks

    def setup(self, **kwargs):
        self.step("setup")

    def initialise(self):
        self.until = time.monotonic() + random.random() * self.get_input("longest")

    def step(self, name):
        if name == self.breaks:
            raise RuntimeError(f"it broke at {time.monotonic()}")

    def update(self):
        self._set_output("number", random.random())
        self.feedback_message = f"at {time.monotonic()}"
        if time.monotonic() < self.until:
            return Status.RUNNING
        self.step("update")
        if random.random() < 0.5:
            self._set_output("words", [str(random.random())])
        return random.choice([Status.SUCCESS, Status.SUCCESS, Status.FAILURE])

    def shutdown(self):
        self.step("shutdown")
'''
TREE = """\
format: stretch-tree/1
tick: 5 ms
imports: {own: own_chance, timer: py_trees.timers.Timer}
trees:
  main:
    repeat:
      times: 4
      do:
        sequence:
          - force_success: {own.Chance: {number: $number, words: $words, breaks: BREAKS}}
          - timer: {duration: 0.01}
          - force_success: {timeout: {after: 20 ms, do: {own.Chance: {longest: 0.1}}}}
    finally: [force_success: {own.Chance: {}}]
"""


@pytest.fixture
def record(tmp_path):
    (tmp_path / "own_chance.py").write_text(MODULE)
    sys.modules.pop("own_chance", None)

    def recorded(breaks="''"):
        tree = tmp_path / "tree.yaml"
        tree.write_text(TREE.replace("BREAKS", breaks))
        result = run(tree, out=tmp_path / "record")
        sys.modules["own_chance"].MADE.clear()
        return result

    recorded.folder = tmp_path / "record"
    yield recorded
    sys.modules.pop("own_chance", None)


@pytest.mark.parametrize("breaks", ["''", "setup", "update", "shutdown"])
def test_it_did_the_same_without_being_made(record, breaks):
    assert record(breaks).status == ("SUCCESS" if breaks == "''" else "ERROR")
    again = replay(record.folder, trust=True)
    assert again.identical, again.first_difference
    assert sys.modules["own_chance"].MADE == []


def test_every_shutdown_that_broke_breaks_again_and_none_is_called(record, tmp_path):
    ends = TREE.replace("own.Chance: {}}", "own.Chance: {breaks: shutdown}}")
    (tmp_path / "tree.yaml").write_text(ends.replace("BREAKS", "shutdown"))
    result = run(tmp_path / "tree.yaml", out=record.folder)
    assert len([text for text in result.errors if "shutdown() broke" in text]) == 2
    made = sys.modules["own_chance"].MADE
    made.clear()
    again = replay(record.folder, trust=True)
    assert again.identical, again.first_difference
    assert made == []


def test_a_changed_status_is_a_difference_of_what_follows(record):
    record()
    log = record.folder / "events.jsonl"
    lines = log.read_text().splitlines()
    events = [json.loads(line) for line in lines]
    [found, *_] = [n for n, e in enumerate(events) if e.get("path", "").endswith("/timer") and e["status"] == "SUCCESS"]
    changed = {**events[found], "status": "FAILURE"}
    lines[found] = json.dumps(changed, sort_keys=True, separators=(",", ":"))
    log.write_text("\n".join(lines) + "\n")
    again = replay(record.folder, trust=True)
    assert not again.same
    assert again.damage


def test_a_class_beside_the_tree_is_not_executed_without_trust(record):
    record()
    sys.modules.pop("own_chance", None)
    with pytest.raises(RecordError, match="add --trust"):
        replay(record.folder)
    assert "own_chance" not in sys.modules
