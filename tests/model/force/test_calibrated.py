import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model import CalibratedHertz, ForceModel, StretchState, next_indentation

MODEL = ForceModel.default()
RADIUS = st.floats(0.0025, 0.040)
STRETCH = st.floats(0.0, 0.080)
DEPTH = st.floats(1e-4, 0.030)


def test_default_spans_the_papers_figures():
    moduli = [MODEL.modulus(0.010, x)[0] for x in np.linspace(0, 0.06, 7)]
    assert moduli[0] == pytest.approx(4.4e3, rel=1e-3)
    assert moduli[-1] == pytest.approx(9.0e3, rel=1e-3)
    assert np.all(np.diff(moduli) > 0)
    fall = MODEL.modulus(0.015, 0.02)[0] / MODEL.modulus(0.005, 0.02)[0]
    assert 0.70 <= fall <= 0.75


@given(radius=RADIUS, stretch=STRETCH, depth=DEPTH)
def test_both_inverses_are_exact(radius, stretch, depth):
    force, sd = MODEL.predict(radius, stretch, depth)
    assert 0 < sd < 0.1 * force
    assert MODEL.depth_for(radius, stretch, force) == pytest.approx(depth, rel=1e-9)
    assert MODEL.stretch_for(radius, depth, force) == pytest.approx(stretch, rel=1e-9, abs=1e-12)


@given(radius=RADIUS, stretch=STRETCH, depth=DEPTH, more=st.floats(0, 0.08))
def test_next_indentation_keeps_the_force(radius, stretch, depth, more):
    force, _ = MODEL.predict(radius, stretch, depth)
    following = min(stretch + more, 0.080)
    again, _ = MODEL.predict(radius, following, next_indentation(MODEL, radius, following, force))
    assert again == pytest.approx(force, rel=1e-9)


def test_no_depth_is_no_force():
    assert MODEL.predict(0.01, 0.02, 0.0) == (0.0, 0.0)
    assert MODEL.depth_for(0.01, 0.02, 0.0) == 0.0


@pytest.mark.parametrize(
    ("ask", "kind", "said"),
    [
        (lambda m: m.predict(0.070, 0.0, 0.01), InvalidInput, "radius 70 mm .* 2.5 mm to 60 mm"),
        (lambda m: m.predict(0.010, 0.1, 0.01), InvalidInput, "stretch 100 mm .* 0 mm to 80 mm"),
        (lambda m: m.predict(0.010, 0.0, 0.04), InvalidInput, "depth 40 mm .* 0 mm to 30 mm"),
        (lambda m: m.predict(math.nan, 0.0, 0.01), InvalidInput, "radius"),
        (lambda m: m.predict(0.0, 0.0, 0.01), InvalidInput, "radius"),
        (lambda m: m.predict(-0.01, 0.0, 0.01), InvalidInput, "radius"),
        (lambda m: m.predict(math.inf, 0.0, 0.01), InvalidInput, "radius"),
        (lambda m: m.depth_for(0.010, 0.0, -1.0), InvalidInput, "force"),
        (lambda m: m.depth_for(0.010, 0.0, math.nan), InvalidInput, "force"),
        (lambda m: m.depth_for(0.010, 0.0, 50.0), NoEquilibrium, "past the calibrated 30 mm"),
        (lambda m: m.stretch_for(0.010, 0.01, 50.0), NoEquilibrium, "the calibrated stretches give"),
        (lambda m: m.stretch_for(0.010, 0.01, 0.0), NoEquilibrium, "no stretch gives 0 N"),
        (lambda m: m.stretch_for(0.010, 0.0, 1.0), NoEquilibrium, "depth 0"),
    ],
)
def test_out_of_range_and_out_of_reach(ask, kind, said):
    with pytest.raises(kind, match=said):
        ask(MODEL)


def test_sd_is_that_of_drawn_parameters():
    """The stated sd of E* is the spread of E* when every parameter is drawn from its own sd."""
    random = np.random.default_rng(0)
    drawn = []
    for _ in range(400):
        states = tuple(
            replace(
                s,
                floor=random.normal(s.floor, s.floor_sd),
                amplitude=random.normal(s.amplitude, s.amplitude_sd),
                decay=random.normal(s.decay, s.decay_sd),
            )
            for s in MODEL.states
        )
        drawn.append(replace(MODEL, states=states).modulus(0.02, 0.03)[0])
    assert np.std(drawn) == pytest.approx(MODEL.modulus(0.02, 0.03)[1], rel=0.12)


def test_a_model_survives_its_file(tmp_path):
    MODEL.save(tmp_path / "hand.json")
    loaded = ForceModel.load(tmp_path / "hand.json")
    assert loaded == MODEL
    assert "assumption" in loaded.provenance["source"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "stretch-calibration/9"}, "format"),
        ({"kind": "oracle"}, "oracle"),
        ({"states": []}, "two different stretches"),
        ({"log_scale": 0.0}, "log_scale"),
        ({"range": {"radius": [0, 1]}}, "range: it has the ends of"),
        ({"range": {"radius": [0, 5], "stretch": [0, 0.08], "depth": [0, 0.01]}}, "range.radius: .* from 0 to 1 m"),
        ({"range": {"radius": [0, 0.1], "stretch": [0, 5], "depth": [0, 0.01]}}, "range.stretch: .* from 0 to 0.2 m"),
        ({"relative_sd": -1}, "relative_sd: .* not -1"),
        ({"shallow_sd": "much"}, "shallow_sd: .* not 'much'"),
    ],
)
def test_a_bad_file_is_refused(tmp_path, change, said):
    path = tmp_path / "hand.json"
    MODEL.save(path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(InvalidInput, match=said):
        ForceModel.load(path)


def test_a_missing_or_broken_file_is_refused(tmp_path):
    (tmp_path / "hand.json").write_text("{")
    for name in ("hand.json", "none.json"):
        with pytest.raises(InvalidInput, match=name):
            ForceModel.load(tmp_path / name)


def test_a_hand_that_does_not_stiffen_has_no_stretch_for_a_force():
    state = StretchState(0.0, 5e3, 0.0, 0.0, 0.0, 0.02, 0.0)
    flat = CalibratedHertz((state, replace(state, stretch=0.06)), 0.02, 0.0, MODEL.range)
    force, sd = flat.predict(0.01, 0.03, 0.01)
    assert sd == 0.0
    with pytest.raises(NoEquilibrium):
        flat.stretch_for(0.01, 0.01, 2 * force)
