import json
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.accuracy.force.hands import TrueHand
from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.strategies.model import MEMBRANE_DEPTHS, MEMBRANE_RADII, STRETCHES
from stretch_bt.model import ForceModel, MembraneModel
from stretch_bt.model.force.force_model import Range
from stretch_bt.model.force.membrane import MembraneHand
from stretch_bt.simulation.membrane.sheet.hanging import hang

LIMITS = Range((0.004, 0.06), (0.0, 0.08), (0.0, 0.025))
COVARIANCE = tuple(map(tuple, np.diag(np.array([2e3, 5e-5, 5e-4, 0.03, 0.1, 0.01]) ** 2).tolist()))
MODEL = MembraneModel(MembraneHand(68.4e3, 0.002, 0.0119, 0.1, 0.7, 0.08), COVARIANCE, 0.01, LIMITS, {"source": "test"})


@given(radius=MEMBRANE_RADII, stretch=STRETCHES, depth=MEMBRANE_DEPTHS)
def test_both_inverses_are_exact(radius, stretch, depth):
    force, sd = MODEL.predict(radius, stretch, depth)
    assert 0.01 * force <= sd < 0.5 * force
    assert MODEL.depth_for(radius, stretch, force) == pytest.approx(depth, rel=1e-9)
    if depth > 1e-3:  # lighter, a slack membrane that hangs presses harder than a tighter one
        assert MODEL.stretch_for(radius, depth, force) == pytest.approx(stretch, rel=1e-9, abs=1e-10)


@given(radius=MEMBRANE_RADII, stretch=STRETCHES, depth=MEMBRANE_DEPTHS, more=st.floats(0.001, 0.01))
def test_force_rises_with_depth_and_goes_to_nothing(radius, stretch, depth, more):
    force, _ = MODEL.predict(radius, stretch, depth)
    assert MODEL.predict(radius, stretch, min(depth + more, MODEL.deepest(radius, stretch)))[0] >= force
    assert MODEL.predict(radius, stretch, 1e-9)[0] < 2e-3
    assert MODEL.predict(radius, stretch, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("stretch", [0.0, 0.01, 0.03])
@pytest.mark.parametrize("seed", range(4))
def test_a_membrane_hangs_as_the_solved_sheet(seed, stretch):
    true = TrueHand.drawn(seed)
    own = MembraneHand(true.shear_modulus, true.thickness, true.mount_prestretch, true.share)
    solved = -float(hang(true.sheet(), stretch).points(21, 41)[20, 10, 2])
    assert own.hang(stretch, 0.0) == pytest.approx(solved, rel=0.03)
    assert own._replace(softening=0.2).hang(stretch, 0.08) == pytest.approx(own.hang(stretch, 0.0) / 0.8)


def test_a_file_without_what_was_measured_is_read(tmp_path):
    path = tmp_path / "hand.json"
    MODEL.save(path)
    kept = json.loads(path.read_text())
    del kept["measured"]
    path.write_text(json.dumps(kept))
    assert ForceModel.load(path) == MODEL
    assert MODEL.in_range(0.02, 0.08, 0.02)
    assert not MODEL.in_range(0.07, 0.08, 0.02)


def test_what_a_file_cannot_hold_is_refused_before_it_is_written(tmp_path):
    with pytest.raises(InvalidInput, match="the provenance has a number that is not finite"):
        replace(MODEL, provenance={"max_force": math.inf}).save(tmp_path / "hand.json")
    assert not (tmp_path / "hand.json").exists()


def test_a_file_holds_it(tmp_path):
    path = tmp_path / "hand.json"
    MODEL.save(path)
    again = ForceModel.load(path)
    assert again == MODEL
    kept = json.loads(path.read_text())
    assert kept["sd"]["mount_prestretch"] == pytest.approx(5e-4)
    kept["hand"]["thickness"] = -1
    path.write_text(json.dumps(kept))
    with pytest.raises(InvalidInput, match="thickness"):
        ForceModel.load(path)


def test_threads_that_ask_one_model_get_their_own_answers():
    """The curve that is kept was read after another thread had put its own there."""
    asked = [(0.01, 0.0, 0.005), (0.03, 0.06, 0.005)]
    alone = [MODEL.predict(*each) for each in asked]
    model, before = replace(MODEL), sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda each: {model.predict(*each) for _ in range(3000)}, asked))
    finally:
        sys.setswitchinterval(before)
    assert found == [{one} for one in alone]


def test_a_range_without_a_width_is_refused():
    with pytest.raises(InvalidInput, match=r"range\.stretch"):
        replace(MODEL, range=replace(LIMITS, stretch=(0.0, 0.0)))


def test_slacker_than_its_table_it_states_how_little_it_knows():
    """A flat sheet 2 mm past its gauge, under 20 mm: 5 mN at 4 mm of depth, 76 mN at 10 mm."""
    weightless = MembraneHand(47.4e3, 0.002, 0.002)
    slack, inside = replace(MODEL, hand=weightless), replace(MODEL, hand=weightless._replace(mount_prestretch=0.004))
    for depth, flat in ((0.004, 0.005), (0.010, 0.076)):
        force, sd = slack.predict(0.01, 0.0, depth)
        assert abs(force - flat) < 2 * sd
        assert slack.predict(0.01, 0.0021, depth)[1] < 0.5 * slack.predict(0.01, 0.0021, depth)[0]
    assert not slack.in_range(0.01, 0.0, 0.005)
    assert slack.in_range(0.01, 0.0021, 0.005)
    assert inside.in_range(0.01, 0.0, 0.005)
    far = replace(slack, hand=weightless._replace(mount_prestretch=0.012), range=replace(LIMITS, stretch=(0.0, 0.12)))
    assert (far.in_range(0.02, 0.107, 0.005), far.in_range(0.02, 0.119, 0.005)) == (True, False)
