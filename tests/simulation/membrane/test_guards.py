"""Guards of the sheet solver: no step through a thin body, and no answer where only rounding is left or a body has sunk in."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.sheet.check import check
from stretch_bt.simulation.membrane.sheet.mesh import Mesh, breakpoints
from stretch_bt.simulation.membrane.sheet.newton import Newton, Outcome, _rounded
from stretch_bt.simulation.membrane.sheet.problem import GRADIENT, Contact, Evaluation, Problem
from stretch_bt.simulation.membrane.sheet.spline import Axis


def problem_of(indenter, depth, stiffness=2.0):
    zones = [Zone(-4.0, 4.0, 3.0)]
    mesh = Mesh(Axis(breakpoints(90.0, zones, 4.0)), Axis(breakpoints(100.0, zones, 4.0)))
    (body,) = place(indenter, (0.0, 0.0), (0.0, 0.0), depth)
    problem = Problem(mesh, np.array((0.5, 0.0, 1.0, 0.0, 0.0, 0.0)), [Contact(body, stiffness, 0.05)], 1e-3)
    flat = np.concatenate([mesh.rest * [0.95, 1.1], np.zeros((*mesh.shape[:2], 1))], axis=2)
    return problem, np.ascontiguousarray(flat)


@pytest.mark.parametrize("indenter", [Wire(0.001, 0.02), Sphere(0.02)])
def test_no_step_is_longer_than_a_body_is_thick(indenter):
    problem, flat = problem_of(indenter, 0.006)
    flat[1:-1] += np.random.default_rng(0).normal(0, 1.0, flat[1:-1].shape)  # far from balance
    sizes = []

    def done(step):
        sizes.append(step.size)
        return len(sizes) == 6

    Newton(problem, flat).run(done, 60)
    assert problem.largest_step <= indenter.bulk / 1e-3 / 4
    assert max(sizes) == pytest.approx(problem.largest_step)  # that far at first, and never farther


@given(left=st.one_of(st.just(0.0), st.floats(1e-6, 2.0)), gain=st.sampled_from([0.0, 1e-14, 1e-6]))
def test_a_state_is_rounded_only_in_balance(left, gain):
    gradient = np.zeros((3, 1, 3))
    gradient[1, 0, 2] = left
    here = Evaluation(1.0, gradient, np.array([[0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]]), np.zeros(3))
    direction = np.array([[[0.0, 0.0, -gain / left if left else 0.0]]])
    assert _rounded(here, direction) == (left <= 1e-3 and gain * (left > 0) < 1e-12)


@pytest.mark.parametrize(("depth", "sinks"), [(0.0002, False), (0.006, True)])
def test_a_body_that_has_sunk_in_is_no_answer(depth, sinks):
    problem, flat = problem_of(Sphere(0.02), depth)
    outcome = Outcome(flat, problem.evaluate(flat, GRADIENT))
    assert outcome.evaluation.totals[0, 5] > 0  # points in contact
    result = SimpleNamespace(
        force=np.array([0, 0, 1.0]), sheet=SimpleNamespace(unit=1e-3), load=SimpleNamespace(travel=depth)
    )
    if sinks:
        with pytest.raises(NoEquilibrium, match="sinks through the sheet"):
            check(result, problem, outcome)
    else:
        check(result, problem, outcome)
