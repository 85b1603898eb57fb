"""Long runs, short: quantities that must stay the same do, and any that changes is noticed."""

import math
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest
from drifts.course import Course, Finding
from drifts.presses import presses
from drifts.revolutions import revolutions
from drifts.ticks import TREE, ticks

from stretch_bt.simulation.dough.lump import STEP, Lump, Rolled

#: what depends on the machine of the moment, which a short run says nothing about
OF_MACHINE = ("CPU", "memory")


@pytest.fixture(autouse=True)
def no_yardstick(monkeypatch):
    """Compute nothing beside the steps: how fast the machine is is not looked at here."""
    monkeypatch.setattr("drifts.course.yardstick", lambda: 0.01)


def bad(findings, *, machine=True):
    return [f.name for f in findings if not f.good and (machine or not any(word in f.name for word in OF_MACHINE))]


def course(pace, size, steps=1000):
    """Run a course in which step k takes `pace(k)`, s, and leaves `size(k)`, MB."""
    state = {"time": 0.0, "step": 0}
    run = Course(1000, lambda: state["time"], lambda: 0.01, lambda: size(state["step"]))
    for k in range(1, steps + 1):
        state["time"] += pace(k)
        state["step"] = k
        run.done(k)
    return bad(run.findings())


@pytest.mark.parametrize(
    ("pace", "size", "said"),
    [
        (lambda k: 1.0, lambda k: 100.0, []),
        (lambda k: 1.0 + 0.09 * (k > 500), lambda k: 100.0 + 0.004 * k, []),
        (lambda k: 1.0, lambda k: 100.0 + min(k, 100), []),  # what is loaded at first
        (lambda k: 1.0 + 2e-4 * k, lambda k: 100.0, ["CPU a step in the last tenth over that in the first"]),
        (lambda k: 1.0 + 50.0 * (k == 990), lambda k: 100.0, []),  # another process came between
        (lambda k: 1.0, lambda k: 100.0 + 0.007 * k, ["growth of it from the 10th hundredth to the 100th"]),
    ],
)
def test_a_course_tells_growth_and_slowing_down(pace, size, said):
    assert course(pace, size) == said


def test_a_course_that_was_not_gone_to_its_end_is_no_good():
    assert course(lambda k: 1.0, lambda k: 100.0, steps=999) == ["steps of 1000 that were not done"]
    with pytest.raises(SystemExit, match="at least 100 steps"):
        Course(99)


def test_what_is_no_number_is_within_no_bound():
    assert not Finding("force", math.nan, 0.01).good


def test_presses_stay_what_they_are():
    assert bad(presses(100, apart=25), machine=False) == []


def test_a_solver_that_drifts_is_noticed():
    pressed = count()

    def creeping(indenter, stretch, depth, **options):
        return SimpleNamespace(force=100 * (depth + 4e-6 * next(pressed)))  # that of a spring: no answer of the sheet

    found = bad(presses(100, apart=25, solve=creeping), machine=False)
    assert found == [
        "their largest difference from the first, a part of it",
        "from a press that starts from flat",
        "of the last such from the first such",
    ]


@pytest.mark.slow
def test_a_lump_keeps_its_shape_with_half_of_the_step():
    assert bad(revolutions(100, paths=["eight"]), machine=False) == []


def test_a_lump_that_a_finer_step_makes_larger_and_that_loses_volume_is_noticed(monkeypatch):
    rolled, coarse = Lump.rolled, 4 * STEP

    def wrong(lump, *way, step, **options):
        lump, steps = rolled(lump, *way, step=step, **options)
        ball = lump if step == coarse else replace(lump, radii=1.012 * lump.ball * np.ones(len(lump.radii)))
        return ball, Rolled(steps.heights, steps.missing + 2e-3)

    monkeypatch.setattr(Lump, "rolled", wrong)
    found = bad(revolutions(100, paths=["eight"], steps=(coarse, coarse / 2)), machine=False)
    assert found[:2] == [
        "eight: volume missing in a step, the largest part of it",
        "eight: change of radius with half of the step",
    ]


def test_a_task_goes_on_for_so_many_ticks():
    assert bad(ticks(100), machine=False) == []


def test_a_task_that_ends_early_is_noticed():
    with pytest.raises(SystemExit, match="force_limit"):
        ticks(100, tree=TREE.replace("20 N", "0.01 N"))
