import pytest

from stretch_bt.simulation.membrane.sheet.settings import Settings

SAMPLE = 12


@pytest.fixture(scope="module")
def sample(random_presses):
    return random_presses.solve_many(SAMPLE)


def test_a_sample_ends_in_a_force_or_a_reason(random_presses, sample):
    for outcome in sample:
        if outcome.found is None:
            assert len(outcome.reason) > 20
        else:
            assert outcome.found.force > 0
            assert outcome.found.force_error > 0
            assert outcome.found.iterations <= Settings().budget
    assert sum(o.end == random_presses.FAILED for o in sample) == 0
    assert sum(o.found is not None for o in sample) > 0.7 * SAMPLE


@pytest.mark.slow
def test_a_sample_again_on_half_the_mesh(random_presses, sample):
    assert sorted(a.ratio for a in random_presses.solve_again(sample, 4))[2] <= 3


@pytest.mark.slow
def test_a_thousand(random_presses):
    outcomes = random_presses.solve_many(1000)
    failed = [o for o in outcomes if o.end == random_presses.FAILED]
    assert len(failed) <= 5, [(o.case, o.reason) for o in failed]
    slipped = [o.case for o in outcomes if o.end == random_presses.SLIPPED]
    assert len(slipped) <= 15
    assert all(case.room[0] < 0.010 for case in slipped)  # near the free edge, and nowhere else
    again = list(random_presses.solve_again(outcomes, 100))
    assert sum(a.ratio <= 3 for a in again) >= 95, [(a.case, a.ratio, a.reason) for a in again if a.ratio > 3]
