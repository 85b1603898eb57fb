"""What holds for the hypotheses of all shapes."""

import math

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.size.hypothesis import HYPOTHESES, Context, hypothesis
from stretch_bt.perception.size.prior import shipped_prior
from stretch_bt.perception.size.start import Start

START = Start(0.0, 0.0, 8e-3, 8e-3, 6e-3, 8e-3, 6e-3, 0.1)


@pytest.mark.parametrize("name", HYPOTHESES)
@pytest.mark.parametrize("places", [[2], [3], [2, 3]])
@pytest.mark.parametrize("length", [0.0, -1e-3])
def test_a_shape_that_shrank_to_nothing_has_a_prior_and_no_size(name, places, length):
    """A fit of a fuzzed frame ended at a half axis of exactly 0, and its logarithm was taken."""
    shape = hypothesis(name, Context(20e-3, 1e-3, 0.0, shipped_prior()))
    q = shape.starts(START)[0]
    q[places] = length
    assert not math.isnan(shape.log_prior(q))
    if 2 in places or name in ("ellipse", "rectangle"):
        with pytest.raises(IllConditioned):
            shape.measure(q, 1e-8 * np.eye(q.size))
