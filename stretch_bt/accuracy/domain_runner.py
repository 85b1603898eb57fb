"""The runner: how long a tick takes by the nodes that it ticks, bare py_trees beside."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.accuracy.advice import DomainSummaries
from stretch_bt.accuracy.job import NODES, Domain, Job, Panel
from stretch_bt.accuracy.points import Kind, Setting

__all__ = ["DOMAIN"]

ABOUT = """\
A sequence without memory, so that every leaf is ticked on every tick; each leaf reads one port and writes one. There is no error here:
the figure is how late a decision comes, the wall time of a tick. A case is a round with a tree of its own: the median of 30 ticks after
5 others, and in the rows the slowest of them. The record writes all leaves' ends and writes on every tick, which no task does: it
writes a few keys a tick. Wall times were taken at the highest priority on a machine with other work."""

KINDS = {"latency": Kind("ms", 1e3, "s", ""), "slowest": Kind("ms", 1e3, "s", "")}
PEERS = frozenset({"py_trees, no ports", "py_trees, its own ports"})
OMITTED = {
    "the slowest tick of a round": "it is the machine's more than the tree's; the rows have it",
    "what nodes and devices themselves take": "`stretch-bt run TREE --stats` says it for a task: its row `all else` holds nodes, ticks and record",
    "C++ engines": "they tick no Python node",
}


def take(found: DomainSummaries) -> str:
    """Say what a tick takes."""
    plain = found.setting(Setting("stretch-bt, no record", "100 nodes"), "latency", NODES)
    bare = found.setting(Setting("py_trees, no ports", "100 nodes"), "latency", NODES)
    return (
        f"So take the record along: where all of 100 nodes end and write on every tick, it is {found.default('latency', NODES)} "
        f"of the 50 ms between two ticks, and in a task one or two nodes do so at a time. "
        f"Without the record it is {plain}; bare py_trees takes {bare}."
    )


def warm() -> None:
    """Tick each kind of tree."""
    from stretch_bt.accuracy.runner import ticks

    ticks.warm()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield every kind of tree at every size, round by round."""
    from stretch_bt.accuracy.runner import ticks

    yield from ticks.jobs()


PANELS = (Panel("latency", NODES, (), "wall time of a tick"),)
DOMAIN = Domain(ABOUT, KINDS, PANELS, take, OMITTED, warm, jobs, PEERS)
