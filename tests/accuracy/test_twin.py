"""The comparison of a scene with and without an effect."""

import math
import sys
from types import SimpleNamespace

import pytest

from stretch_bt.accuracy.twin import ledger
from stretch_bt.accuracy.twin.judge import change, judge
from stretch_bt.accuracy.twin.ledger import Ledger, Runs
from stretch_bt.accuracy.twin.outcome import TaskFigures, outcome, with_effects
from stretch_bt.simulation.scene import load_scene

SCENE = load_scene("calibration_sphere")  # tolerates 3 % of force and 0.3 mm of height


def runs(*forces):
    return Runs([TaskFigures({"height": 0.060, "force": f} if f else {}, 1.0, "" if f else "fails") for f in forces])


@pytest.mark.parametrize(
    ("base", "other", "mean", "rms"),
    [
        (runs(1.0, 1.0), runs(1.0, 1.0), 0.0, 0.0),
        (runs(1.0, 1.0), runs(1.06, 1.06), 2.0, 2.0),
        (runs(1.0, 1.0), runs(1.03, 0.97), 0.0, 1.0),  # at random: nothing in the mean, all in each run
        (runs(1.0, 2.0), runs(1.0, None), math.inf, math.inf),
        (runs(1.0, 1.0, 1.0, 1.0), runs(1.0, 1.0, 1.0, None), 0.0, 0.0),
        (runs(None, None), runs(None, None), math.inf, math.inf),  # nothing can be compared
    ],
)
def test_a_change_counts_by_its_tolerance_in_the_mean_and_in_each_run(base, other, mean, rms):
    assert change(SCENE, base, other) == pytest.approx((mean, rms))


@pytest.fixture(scope="module")
def pressed():
    """The outcome of one press of the calibration sphere."""
    return outcome(with_effects("calibration_sphere", {"sag": "off", "fixed_pattern": "off"}), 0)


def test_outcomes_are_kept_and_belong_to_the_text_of_the_scene(tmp_path, monkeypatch, pressed):
    asked = []
    monkeypatch.setattr(ledger, "outcome", lambda text, seed: asked.append((text, seed)) or pressed)
    path = tmp_path / "kept.jsonl"
    first = Ledger(path, workers=1).runs("calibration_sphere", ["sag"], ["sag", "bending"], [0])
    assert first.outcomes == [pressed]
    assert asked == [(with_effects("calibration_sphere", {"bending": "off", "sag": "on"}), 0)]
    again = Ledger(path, workers=1)
    assert again.runs("calibration_sphere", ["sag"], ["sag", "bending"], [0]).outcomes == first.outcomes
    assert len(path.read_text().splitlines()) == 1
    path.write_text(path.read_text().replace('"text": "', '"text": "other'))
    Ledger(path, workers=1).runs("calibration_sphere", ["sag"], ["sag", "bending"], [0])
    assert len(path.read_text().splitlines()) == 2


def test_a_press_measures_what_the_scene_holds(pressed):
    assert pressed.values["height"] == pytest.approx(0.060, abs=2e-4)
    assert 0.5 < pressed.values["force"] < 3.0
    assert pressed.cpu_seconds > 0


def test_an_interrupted_run_ends_the_measurement(monkeypatch):
    """It was a task that failed, and the next one was begun."""
    module = sys.modules[outcome.__module__]
    monkeypatch.setattr(module, "run", lambda *_, **__: SimpleNamespace(status="INTERRUPTED", reason="stopped"))
    with pytest.raises(KeyboardInterrupt):
        outcome(with_effects("water_balloon", {}), 0)


@pytest.mark.slow
def test_each_effect_that_a_scene_can_have_is_judged():
    few = dict.fromkeys(("friction", "mullins"), 1)
    found = judge("calibration_sphere", Ledger(None, workers=1), [0], few)
    assert {j.verdict.name for j in found} >= {"sag", "bending", "white_noise", "repeatability"}
    assert next(j for j in found if j.verdict.name == "sag").mean > 1
    assert next(j for j in found if j.verdict.name == "wrinkling").mean < 0.1
