"""palpate_active in the twin at hertz fidelity, whose force law is the paper's."""

from itertools import pairwise

import pytest


@pytest.fixture
def palpate(run, hand_at, pressed, at_hertz, tmp_path):
    """Return what runs the tree on a shipped balloon: its result, and the scene's own force at each press."""

    def palpated(balloon, seed, **params):
        scene = at_hertz(f"{balloon}_balloon", tmp_path)
        forces, watch = pressed
        forces.clear()
        params = {"model": "paper", **params}
        return run("palpate_active", cell=hand_at(75), scene=scene, seed=seed, params=params, watch=watch), forces

    return palpated


@pytest.mark.parametrize(("balloon", "seed"), [pytest.param("water", 1, marks=pytest.mark.slow), ("seeds", 3)])
def test_the_wanted_deviation_is_reached_at_forces_that_never_fall(palpate, balloon, seed):
    result, forces = palpate(balloon, seed)
    assert result.status == "SUCCESS", result.reason
    out, truth = result.outputs, result.truth
    for name in ("stiffness", "force", "deflection"):
        assert abs(out[name]["value"] - truth[name]["value"]) < 4 * out[name]["sd"], name
    # 5 % are wanted, of which a press that may lower the top by no more than twice the drop leaves up to 9 where the power is not known
    assert out["stiffness"]["sd"] <= 0.09 * out["stiffness"]["value"]
    assert out["hold"]["value"] >= 3.5
    assert len(forces) == out["presses"]["value"] >= 2
    assert all(after > 0.98 * before for before, after in pairwise(forces))


@pytest.mark.slow
def test_less_is_wanted_in_less_time_and_a_bound_of_presses_holds(palpate):
    hurried, _ = palpate("pudding", 2, wanted_error=0.15, min_hold=0.0, settle=0.0)
    careful, _ = palpate("pudding", 2, wanted_error=0.06, min_hold=0.0, settle=0.0)
    bounded, _ = palpate("pudding", 2, wanted_error=0.001, min_hold=0.0, settle=0.0, max_presses=2)
    for result in (hurried, careful, bounded):
        assert result.status == "SUCCESS", result.reason
    assert hurried.outputs["robot_time"]["value"] < careful.outputs["robot_time"]["value"]
    sds = [r.outputs["stiffness"]["sd"] / r.outputs["stiffness"]["value"] for r in (hurried, careful)]
    assert sds[1] < 0.07 < sds[0] < 0.17
    assert bounded.outputs["presses"]["value"] <= 2


def test_no_press_begins_after_the_time_there_is(palpate):
    result, _ = palpate("seeds", 4, wanted_error=0.001, min_hold=0.0, max_time=1.0)
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["presses"]["value"] == 1


def test_a_depth_limit_below_the_first_press_is_refused_before_moving(palpate):
    result, forces = palpate("water", 0, max_depth=0.005)
    assert result.status == "FAILURE"
    assert result.reason.startswith("main/depth_allowed: ")
    assert forces == []
