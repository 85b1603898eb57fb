"""The ladder of force models, and the hands that they do not know."""

import numpy as np
import pytest

from stretch_bt.accuracy.domain_force import DOMAIN
from stretch_bt.accuracy.force.hands import DEPTHS, DIAMETERS, STRETCHES, TrueHand, forces_of, measured_at
from stretch_bt.accuracy.force.ladder import HERTZ, PAPER, SOLVED, TABLE
from stretch_bt.simulation.membrane.sheet.settings import Settings


def test_each_model_is_better_than_the_one_before(measured):
    errors = {}
    for row in measured("force", DOMAIN, [*DOMAIN.jobs(True)]):
        assert (row.error_kind, row.status, row.default) == ("force", "ok", row.setting == TABLE)
        assert 0 < row.reference_error < 0.01
        errors.setdefault(row.setting, []).append(row.error)
    mean = {name: float(np.mean(values)) for name, values in errors.items()}
    assert mean[HERTZ] > mean[PAPER] > 5 * mean[TABLE]
    assert max(errors[TABLE] + errors[SOLVED]) < 0.02


def test_hands_differ_and_repeat():
    hands = [TrueHand.drawn(seed) for seed in range(20)]
    assert hands == [TrueHand.drawn(seed) for seed in range(20)]
    assert len({h.shear_modulus for h in hands}) == 20
    assert sum(h.share > 0 for h in hands) == 10
    assert all(0.05 <= h.softening <= 0.15 for h in hands)


def test_a_softened_hand_has_less_force_where_it_was_before():
    hand = TrueHand.drawn(0)
    sheet = hand.sheet()
    coarse = Settings(coarsen=2.0)
    diameters, stretches, depths = DIAMETERS[1:2], STRETCHES[[1, 7]], DEPTHS[[4]]
    soft = forces_of(sheet, diameters, stretches, depths, coarse)
    fresh = forces_of(sheet, diameters, stretches[:1], depths, coarse)
    assert soft[0, 0, 0] / fresh[0, 0, 0] == pytest.approx(1 - hand.softening, abs=0.02)


def test_measurements_scatter_about_the_truth_as_they_say():
    true = np.tile(np.linspace(0.2, 3.0, 15), (5, 8, 1))
    off = [(measured_at(true, DIAMETERS, STRETCHES, DEPTHS, s).force - true.ravel()) / 0.02 for s in range(20)]
    assert np.abs(np.mean(off)) < 1.0
    assert 0.8 < np.std(off) < 3.0
