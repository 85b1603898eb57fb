import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.accuracy.force.hands import TrueHand
from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model import ForceModel, MembraneModel
from stretch_bt.model.force.force_model import Range
from stretch_bt.model.force.membrane import PARAMETERS, Hand
from stretch_bt.model.force.membrane_table import Axis, read_table
from stretch_bt.simulation.membrane.sheet.hanging import hang

LIMITS = Range((0.004, 0.06), (0.0, 0.08), (0.0, 0.025))
COVARIANCE = tuple(map(tuple, np.diag(np.array([2e3, 5e-5, 5e-4, 0.03, 0.1, 0.01]) ** 2).tolist()))
MODEL = MembraneModel(Hand(68.4e3, 0.002, 0.0119, 0.1, 0.7, 0.08), COVARIANCE, 0.01, LIMITS, {"source": "test"})
RADIUS = st.floats(0.005, 0.045)
STRETCH = st.floats(0.0, 0.08)
DEPTH = st.floats(1e-4, 0.015)


def test_the_table_rises_with_depth_and_span():
    table = read_table()
    for values in (table.force, MODEL.hand.logarithms(read_table().spans - 0.004, 0.2)):
        assert np.isfinite(values).all()
        assert (np.diff(values, axis=2) > 0).all()
        assert (np.diff(values[..., 1:], axis=1) > 0).all()


def test_a_spline_is_exact_for_cubics_and_goes_on_straight():
    places = np.array([0.0, 0.7, 1.0, 2.5, 3.0, 4.2])
    axis = Axis(places)
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.3])
    inside = np.linspace(0.0, 4.2, 41)
    assert np.allclose(axis.many(inside) @ cubic(places), cubic(inside), atol=1e-12)
    assert axis.weights(5.2) @ cubic(places) == pytest.approx(cubic(4.2) + cubic.deriv()(4.2))
    assert axis.weights(-1.0) @ cubic(places) == pytest.approx(cubic(0.0) - cubic.deriv()(0.0))
    assert np.allclose(axis.slopes() @ cubic(places), cubic.deriv()(places))


@given(radius=RADIUS, stretch=STRETCH, depth=DEPTH)
def test_both_inverses_are_exact(radius, stretch, depth):
    force, sd = MODEL.predict(radius, stretch, depth)
    assert 0.01 * force <= sd < 0.5 * force
    assert MODEL.depth_for(radius, stretch, force) == pytest.approx(depth, rel=1e-9)
    if depth > 1e-3:  # lighter, a slack membrane that hangs presses harder than a tighter one
        assert MODEL.stretch_for(radius, depth, force) == pytest.approx(stretch, rel=1e-9, abs=1e-10)


@given(radius=RADIUS, stretch=STRETCH, depth=DEPTH, more=st.floats(0.001, 0.01))
def test_force_rises_with_depth_and_goes_to_nothing(radius, stretch, depth, more):
    force, _ = MODEL.predict(radius, stretch, depth)
    assert MODEL.predict(radius, stretch, min(depth + more, MODEL.deepest(radius, stretch)))[0] >= force
    assert MODEL.predict(radius, stretch, 1e-9)[0] < 2e-3
    assert MODEL.predict(radius, stretch, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("stretch", [0.0, 0.01, 0.03])
@pytest.mark.parametrize("seed", range(4))
def test_a_membrane_hangs_as_the_solved_sheet(seed, stretch):
    true = TrueHand.drawn(seed)
    own = Hand(true.shear_modulus, true.thickness, true.mount_prestretch, true.share)
    solved = -float(hang(true.sheet(), stretch).points(21, 41)[20, 10, 2])
    assert own.hang(stretch, 0.0) == pytest.approx(solved, rel=0.03)
    assert own._replace(softening=0.2).hang(stretch, 0.08) == pytest.approx(own.hang(stretch, 0.0) / 0.8)


def test_a_hang_is_told_with_what_the_parameters_leave_of_it():
    told = MODEL.hang(0.0)
    assert 0.03 * told.value < told.sd < 0.3 * told.value
    surer = replace(MODEL, covariance=tuple(tuple(v / 100 for v in row) for row in COVARIANCE)).hang(0.0)
    assert surer.value == told.value
    assert surer.sd < told.sd
    assert ForceModel.default().hang(0.0) is None
    slack = replace(MODEL, hand=MODEL.hand._replace(mount_prestretch=1e-3))
    assert slack.hang(0.0) is None
    assert slack.hang(0.01) is not None
    with pytest.raises(InvalidInput, match="stretch"):
        MODEL.hang(0.2)


def test_the_slopes_behind_the_deviation_are_those_of_the_force():
    place = (0.012, 0.033, 0.007)
    for k, name in enumerate(PARAMETERS):
        alone = np.zeros((6, 6))
        step = 1e-3 * max(getattr(MODEL.hand, name), 0.1 if k > 2 else 0)
        alone[k, k] = step**2
        rows = tuple(map(tuple, alone.tolist()))
        _, sd = MembraneModel(MODEL.hand, rows, 0.0, LIMITS).predict(*place)
        moved = MODEL.hand._replace(**{name: getattr(MODEL.hand, name) + step})
        off = MembraneModel(moved, rows, 0.0, LIMITS).predict(*place)[0] - MODEL.predict(*place)[0]
        assert sd == pytest.approx(abs(off), rel=0.03)


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((0.0, 0.01, 0.01), "radius"),
        ((-0.01, 0.01, 0.01), "radius"),
        ((math.inf, 0.01, 0.01), "radius"),
        ((math.nan, 0.01, 0.01), "radius"),
        ((0.01, 0.2, 0.01), "stretch"),
        ((0.01, -0.01, 0.01), "stretch"),
        ((0.01, 0.01, 0.04), "depth"),
        ((0.01, 0.01, -1e-3), "depth"),
        ((0.0041, 0.08, 0.025), "wrap"),
    ],
)
def test_outside_its_range_it_refuses(place, said):
    with pytest.raises(InvalidInput, match=said):
        MODEL.predict(*place)


def test_no_answer_is_said_so():
    with pytest.raises(NoEquilibrium, match="not reached"):
        MODEL.depth_for(0.01, 0.0, 1e3)
    with pytest.raises(NoEquilibrium, match="no stretch gives"):
        MODEL.stretch_for(0.01, 0.01, 1e3)
    with pytest.raises(InvalidInput, match="force"):
        MODEL.depth_for(0.01, 0.0, -1.0)
    assert MODEL.depth_for(0.01, 0.0, 0.0) == 0.0


def broken(**changes):
    """Return a calibration file's fields with some changed, by dotted names."""

    def change(kept):
        for name, value in changes.items():
            *path, last = name.split("__")
            inner = kept
            for key in path:
                inner = inner[key]
            inner[last] = value
        return kept

    return change


def spoiled(kept):
    kept["covariance"][0][1] = kept["covariance"][1][0] = 2 * math.sqrt(
        kept["covariance"][0][0] * kept["covariance"][1][1]
    )
    return kept


def turned(kept):
    kept["covariance"][2][2] *= -1
    return kept


def lopsided(kept):
    kept["covariance"][0][1] = 0.5 * math.sqrt(kept["covariance"][0][0] * kept["covariance"][1][1])
    return kept


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (broken(hand__softening=3), "hand.softening: it is a number from 0 to 0.5, not 3"),
        (broken(hand__shear_modulus=-1), "hand.shear_modulus: .* not -1"),
        (broken(hand__friction="much"), "hand.friction: .* not 'much'"),
        (spoiled, "covariance: some sum of the parameters has a variance below 0"),
        (turned, "covariance: a variance is not below 0"),
        (lopsided, "covariance: it is not symmetric"),
        (broken(covariance=[[1.0]]), "covariance: it has 6 rows of 6"),
        (broken(range__stretch=[0, 5]), "range.stretch: its ends are numbers that rise, from 0 to 0.2 m"),
        (broken(range__stretch=[0, 0.15]), "range.stretch: it is a number from 0 to 0.12, not 0.15"),
        (broken(range__depth=[0, 0.05]), "range.depth: .* 0.025"),
        (broken(range__radius=[0.001, 0.03]), "range.radius: .* from 0.004 to 0.06"),
        (broken(range__radius=[0.03, 0.01]), "range.radius: its ends are numbers that rise"),
        (broken(range=5), "range: it has the ends of radius, stretch, depth"),
        (broken(measured={"radius": [0, 1]}), "measured: it has the ends"),
        (broken(measured__radius=[0, 0.03]), "measured.radius: it is a number from .* not 0"),
        (broken(relative_sd=-0.1), "relative_sd"),
        (broken(conditioned=7), "conditioned: .* 0.2"),
    ],
)  # fmt: skip
def test_a_file_that_holds_no_such_hand_is_refused_by_file_and_field(tmp_path, change, said):
    path = tmp_path / "hand.json"
    replace(MODEL, measured=LIMITS).save(path)
    assert ForceModel.load(path).measured == LIMITS
    path.write_text(json.dumps(change(json.loads(path.read_text()))))
    with pytest.raises(InvalidInput, match=rf"hand\.json: {said}"):
        ForceModel.load(path)


def test_a_file_without_what_was_measured_is_read(tmp_path):
    path = tmp_path / "hand.json"
    MODEL.save(path)
    kept = json.loads(path.read_text())
    del kept["measured"]
    path.write_text(json.dumps(kept))
    assert ForceModel.load(path) == MODEL
    assert MODEL.in_range(0.02, 0.08, 0.02)
    assert not MODEL.in_range(0.07, 0.08, 0.02)


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
