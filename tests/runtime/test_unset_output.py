"""An output that a node leaves absent is unset for the tree, for whoever watches, in the record and in a replay."""

import json
from typing import Any

import pytest

from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.task import run
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, Out, Status
from stretch_bt.units import Estimate, Length


class Comes(Behavior):
    """Finds a width at its first start, and none from then on."""

    width: Out[Length | None]

    def update(self) -> Status:
        self.width = Estimate(0.01, 0.001) if self.runs == 1 else None
        return Status.SUCCESS


HEAD = "keys: {width: Length, error: Length}"
TWICE = "sequence: [repeat: {times: 2, do: {comes: {width: $width%s}}}]"


@pytest.mark.parametrize("wired", ["", ", width_sd: $error"])
def test_watchers_hear_that_an_output_is_left_unset(bench: Any, wired: str) -> None:
    registry.node(Comes)
    tree = bench.build(TWICE % wired, HEAD)
    assert bench.run(tree).status == "SUCCESS"
    keys = ["main/width", "main/error"][: 1 + bool(wired)]
    assert bench.events.writes == [*zip(keys, (0.01, 0.001), strict=False), *((key, None) for key in keys)]
    assert not any(cell.value or cell.sd for cell in tree.cells)


def test_it_is_in_the_record_and_replays_alike(bench: Any) -> None:
    registry.node(Comes)
    bench.program(TWICE % "", HEAD)
    folder = bench.folder / "record"
    assert run(bench.folder / "tree1.yaml", out=folder).status == "SUCCESS"
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text("utf-8").splitlines()]
    written = [(e["value"], e.get("sd")) for e in events if e["type"] == "write"]
    assert written == [(0.01, 0.001), (None, None)]
    found = replay(folder)
    assert (found.identical, found.first_difference) == (True, None)
