import math

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import estimate_stiffness
from stretch_bt.units import Estimate


def test_sd_is_that_of_drawn_values():
    random = np.random.default_rng(1)
    force, deflection = Estimate(1.35, 0.04), Estimate(1.5e-3, 1e-4)
    found = estimate_stiffness(force, deflection)
    drawn = random.normal(force.value, force.sd, 20000) / random.normal(deflection.value, deflection.sd, 20000)
    assert found.value == pytest.approx(900.0)
    assert found.sd == pytest.approx(np.std(drawn), rel=0.05)


@pytest.mark.parametrize("deflection", [Estimate(0.0, 0.0), Estimate(-1e-3, 1e-5), Estimate(3e-4, 1e-4)])
def test_too_little_deflection_is_refused(deflection):
    with pytest.raises(IllConditioned, match="too little to tell"):
        estimate_stiffness(Estimate(1.0, 0.01), deflection)


@pytest.mark.parametrize(
    ("force", "deflection"),
    [
        (Estimate(math.nan, 0.1), Estimate(1e-3, 1e-5)),
        (Estimate(1.0, -0.1), Estimate(1e-3, 1e-5)),
        (Estimate(1.0, 0.1), Estimate(1e-3, math.inf)),
        (Estimate(-1.0, 0.1), Estimate(1e-3, 1e-5)),
    ],
)
def test_bad_input(force, deflection):
    with pytest.raises(InvalidInput):
        estimate_stiffness(force, deflection)


@pytest.mark.parametrize("together", [-0.9, 0.0, 0.9])
def test_sd_of_errors_that_go_together_is_that_of_drawn_values(together):
    random = np.random.default_rng(2)
    force, deflection = Estimate(1.35, 0.04), Estimate(1.5e-3, 4e-5)
    covariance = together * force.sd * deflection.sd
    spread = [[force.sd**2, covariance], [covariance, deflection.sd**2]]
    drawn = random.multivariate_normal([force.value, deflection.value], spread, 20000)
    assert estimate_stiffness(force, deflection, together).sd == pytest.approx(
        np.std(drawn[:, 0] / drawn[:, 1]), rel=0.06
    )


@pytest.mark.parametrize("together", [-1.1, 1.1, math.nan])
def test_a_correlation_beyond_one_is_refused(together):
    with pytest.raises(InvalidInput, match="together"):
        estimate_stiffness(Estimate(1.0, 0.01), Estimate(1e-3, 1e-5), together)
