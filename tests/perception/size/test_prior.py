import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.size.prior import SkirtPrior, shipped_prior


@pytest.mark.parametrize("stretch", [None, 0.0, 0.02, 0.06])
@pytest.mark.parametrize(("depth", "radius"), [(3e-3, 6e-3), (8e-3, 10e-3), (14e-3, 14e-3)])
def test_derivatives_of_the_mean(stretch, depth, radius):
    prior, h = shipped_prior(), 1e-6
    _, slopes = prior.mean(stretch, depth, radius)
    by_depth = (prior.mean(stretch, depth + h, radius)[0] - prior.mean(stretch, depth - h, radius)[0]) / (2 * h)
    by_radius = (prior.mean(stretch, depth, radius + h)[0] - prior.mean(stretch, depth, radius - h)[0]) / (2 * h)
    assert slopes == pytest.approx(np.column_stack([by_depth, by_radius]), rel=1e-4, abs=1e-4)


def test_tension_along_the_stretch_grows_with_it_and_sinks_with_depth():
    prior = shipped_prior()
    ratios = [prior.mean(x, 8e-3, 10e-3)[0][0] for x in (0.005, 0.02, 0.06)]
    assert ratios == sorted(ratios)
    assert ratios[0] > 0.5
    assert prior.mean(0.02, 3e-3, 10e-3)[0][0] > prior.mean(0.02, 14e-3, 10e-3)[0][0] + 0.5


def test_knowing_the_stretch_narrows_the_prior():
    prior = shipped_prior()
    known, unknown = (np.linalg.slogdet(prior.covariance(x))[1] for x in (0.02, None))
    assert known < unknown - 4.0


def test_what_is_beyond_the_presses_stays_as_at_their_edge():
    prior = shipped_prior()
    assert prior.mean(0.02, 8e-3, 40e-3)[0] == pytest.approx(prior.mean(0.02, 8e-3, 30e-3)[0])
    assert np.isfinite(prior.mean(0.0, -1.0, -1.0)[0]).all()


def test_a_prior_survives_its_file():
    prior = shipped_prior()
    again = SkirtPrior.from_json(prior.to_json())
    for stretch in (0.01, None):
        for one, other in zip(prior.mean(stretch, 7e-3, 9e-3), again.mean(stretch, 7e-3, 9e-3), strict=True):
            assert np.array_equal(one, other)
        assert np.array_equal(prior.covariance(stretch), again.covariance(stretch))


@pytest.mark.parametrize("text", ["", "{}", '{"known": {}, "unknown": {}}', "[1]"])
def test_another_file_is_refused(text):
    with pytest.raises(InvalidInput, match="no prior of a skirt"):
        SkirtPrior.from_json(text)
