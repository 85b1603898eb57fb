"""Which presses a protocol has, in what order, and which of them are missing."""

import itertools
import math

import pytest

from stretch_bt.model.calibration.protocol import PROTOCOLS, missing, protocol

COUNTS = {"paper": 11 * 7 * 16 * 5, "sensitivity": 5 * 7 * 15, "tasks": 5 * 8 * 16 * 5}


@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_protocol_has_each_state_once(name):
    states = list(protocol(name).states())
    assert len(states) == len(set(states)) == COUNTS[name]


def test_the_protocols_are_those_of_the_paper_and_of_the_tasks():
    paper, tasks = PROTOCOLS["paper"], PROTOCOLS["tasks"]
    assert list(paper.indenters()) == [
        *(("sphere", d) for d in (0.010, 0.015, 0.020, 0.025, 0.030)),
        *(("cylinder", d) for d in (0.010, 0.015, 0.020, 0.025, 0.030)),
        ("cone", math.radians(45)),
    ]
    assert list(tasks.indenters()) == [("sphere", d) for d in (0.010, 0.020, 0.030, 0.045, 0.060)]
    assert paper.stretches == (0.0, 0.010, 0.020, 0.030, 0.040, 0.050, 0.060)
    assert tasks.stretches == (*paper.stretches, 0.080)
    flat = PROTOCOLS["sensitivity"]
    assert list(flat.indenters()) == [i for i in paper.indenters() if i[0] == "cylinder"]
    assert (flat.stretches, flat.depths, flat.trials) == (paper.stretches, paper.depths[1:], 1)
    assert paper.depths == tasks.depths == tuple(k / 1000 for k in range(16))


@pytest.mark.parametrize("name", PROTOCOLS)
def test_what_takes_longest_changes_most_seldom_and_depths_rise(name):
    states = list(protocol(name).states())
    pairs = list(itertools.pairwise(states))
    assert sum(a.indenter != b.indenter for a, b in pairs) == len(list(protocol(name).indenters())) - 1
    stretched = sum((a.indenter, a.stretch) != (b.indenter, b.stretch) for a, b in pairs)
    wanted = protocol(name)
    assert stretched == COUNTS[name] // (len(wanted.depths) * wanted.trials) - 1
    assert all(a.depth < b.depth for a, b in pairs if a.series == b.series)
    assert all(b.depth == wanted.depths[0] for a, b in pairs if a.series != b.series)


def test_lengths_and_trials_may_be_others():
    chosen = protocol("tasks", diameters=[0.02, 0.01, 0.02], stretches=[0.08], depths=[0.003, 0.001], trials=2)
    assert [(s.size, s.stretch, s.depth, s.trial) for s in chosen.states()] == [
        (size, 0.08, depth, trial) for size in (0.01, 0.02) for trial in (1, 2) for depth in (0.001, 0.003)
    ]
    assert protocol("paper", diameters=[0.02]).cylinders == (0.02,)
    assert protocol("tasks", diameters=[0.02]).cylinders == ()
    assert list(protocol("sensitivity", diameters=[0.02]).indenters()) == [("cylinder", 0.02)]


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("kept", [0, 1, 17, 500])
def test_what_is_missing_goes_on_where_it_ended(name, kept):
    states = list(protocol(name).states())
    assert missing(protocol(name), states[:kept]) == states[kept:]
    assert missing(protocol(name), states) == []
    holes = states[:10] + states[12:]
    assert missing(protocol(name), holes) == states[10:12]
