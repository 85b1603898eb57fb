"""What behaviours of py_trees write, time and again: the newest counts, and nothing of an earlier start is taken for new."""

import json
import shutil
import sys

import pytest

from stretch_bt import run
from stretch_bt.runtime.replay import replay

MODULE = '''
from py_trees.common import Status
from py_trees.ports import BehaviourWithPorts, PortInformation


class Grow(BehaviourWithPorts, register=False):
    """Write one and the same list in every tick, longer each time."""

    INPUT_PORTS = {}
    OUTPUT_PORTS = {"items": PortInformation(data_type=list[int])}

    def initialise(self):
        self.items = []

    def update(self):
        self.items.append(len(self.items))
        self._set_output("items", self.items)
        return Status.SUCCESS if len(self.items) == 3 else Status.RUNNING


class Once(BehaviourWithPorts, register=False):
    """Write at the first start alone."""

    INPUT_PORTS = {}
    OUTPUT_PORTS = {"value": PortInformation(data_type=int), "extra": PortInformation(data_type=int, required=False)}

    def __init__(self, name):
        super().__init__(name=name)
        self.starts = 0

    def update(self):
        self.starts += 1
        if self.starts == 1:
            self._set_output("value", 1)
            self._set_output("extra", 2)
        return Status.SUCCESS


class Twice(Once, register=False):
    """Write the rest at each start."""

    def update(self):
        super().update()
        self._set_output("value", 1)
        return Status.SUCCESS
'''
TREE = "format: stretch-tree/1\ntick: 1 ms\nimports: {own: own_writers}\ntrees:\n  main:\n"


@pytest.fixture
def own(tmp_path):
    (tmp_path / "own_writers.py").write_text(MODULE)
    sys.modules.pop("own_writers", None)

    def ticked(body):
        (tmp_path / "tree.yaml").write_text(TREE + "".join(f"    {line}\n" for line in body.splitlines()))
        shutil.rmtree(tmp_path / "record", ignore_errors=True)
        return run(tmp_path / "tree.yaml", out=tmp_path / "record")

    yield ticked
    sys.modules.pop("own_writers", None)


def test_a_list_that_grew_is_written_again_and_apart_from_the_one_that_goes_on(own, tmp_path):
    result = own("out: [items]\nsequence:\n  - own.Grow: {items}\n")
    assert result.status == "SUCCESS", result.reason
    assert result.keys["items"] == [0, 1, 2]
    log = [json.loads(line) for line in (tmp_path / "record" / "events.jsonl").read_text().splitlines()]
    assert [event["value"] for event in log if event["type"] == "write"] == [[0], [0, 1], [0, 1, 2]]
    assert replay(tmp_path / "record", trust=True).identical


def test_an_output_of_an_earlier_start_is_not_taken_for_new(own):
    result = own("repeat: {times: 2, do: [own.Once: {value: $value}]}\n")
    assert (result.status, result.ticks) == ("ERROR", 2)
    assert "ended with SUCCESS without writing 'value'" in result.reason
    result = own("out: [extra]\nrepeat: {times: 2, do: [own.Twice: {extra}]}\n")
    assert (result.status, result.outputs) == ("SUCCESS", {}), "one that may be absent is none then"
