import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.strategies.model import HERTZ_DEPTHS, HERTZ_RADII, STRETCHES
from stretch_bt.model import ForceModel, next_indentation
from stretch_bt.model.force.calibrated import CalibratedHertz, StretchState
from stretch_bt.model.force.force_model import Range

MODEL = ForceModel.default()


def test_default_spans_the_papers_figures():
    moduli = [MODEL.modulus(0.010, x)[0] for x in np.linspace(0, 0.06, 7)]
    assert moduli[0] == pytest.approx(4.4e3, rel=1e-3)
    assert moduli[-1] == pytest.approx(9.0e3, rel=1e-3)
    assert np.all(np.diff(moduli) > 0)
    fall = MODEL.modulus(0.015, 0.02)[0] / MODEL.modulus(0.005, 0.02)[0]
    assert 0.70 <= fall <= 0.75


@given(radius=HERTZ_RADII, stretch=STRETCHES, depth=HERTZ_DEPTHS)
def test_both_inverses_are_exact(radius, stretch, depth):
    force, sd = MODEL.predict(radius, stretch, depth)
    assert 0 < sd < 0.1 * force
    assert MODEL.depth_for(radius, stretch, force) == pytest.approx(depth, rel=1e-9)
    assert MODEL.stretch_for(radius, depth, force) == pytest.approx(stretch, rel=1e-9, abs=1e-12)


@given(radius=HERTZ_RADII, stretch=STRETCHES, depth=HERTZ_DEPTHS, more=st.floats(0, 0.08))
def test_next_indentation_keeps_the_force(radius, stretch, depth, more):
    force, _ = MODEL.predict(radius, stretch, depth)
    following = min(stretch + more, 0.080)
    again, _ = MODEL.predict(radius, following, next_indentation(MODEL, radius, following, force))
    assert again == pytest.approx(force, rel=1e-9)


def test_a_model_survives_its_file(tmp_path):
    MODEL.save(tmp_path / "hand.json")
    loaded = ForceModel.load(tmp_path / "hand.json")
    assert loaded == MODEL
    assert "assumption" in loaded.provenance["source"]


@pytest.mark.parametrize("floor", [-5e3, -200.0])
def test_a_modulus_that_is_none_gives_no_force(floor):
    """It gave a force and a standard deviation below 0, and a complex depth."""
    states = tuple(StretchState(x, floor, 100.0, 1e3, 100.0, 0.01, 0.001) for x in (0.0, 0.06))
    model = CalibratedHertz(states, 0.01, 0.05, Range((0.005, 0.03), (0.0, 0.06), (0.0, 0.015)))
    for ask in (lambda: model.predict(0.01, 0.0, 0.005), lambda: model.depth_for(0.01, 0.0, 1.0)):
        with pytest.raises(NoEquilibrium, match="no modulus above 0"):
            ask()


@pytest.mark.parametrize(
    ("name", "value"), [("stretch", -0.05), ("stretch", 1.0), ("floor", 10**400)], ids=["below 0", "above", "huge"]
)
def test_a_state_that_is_none_is_refused_when_it_is_read(tmp_path, name, value):
    path = tmp_path / "hand.json"
    MODEL.save(path)
    kept = json.loads(path.read_text())
    kept["states"][0][name] = value
    path.write_text(json.dumps(kept))
    with pytest.raises(InvalidInput, match=r"hand\.json"):
        ForceModel.load(path)
