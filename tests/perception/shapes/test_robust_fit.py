import dataclasses

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.cone import settle_cone
from stretch_bt.perception.shapes.robust_fit import CLOSE
from stretch_bt.perception.shapes.shape import FITTERS
from stretch_bt.perception.shapes.sight import sighted

RNG_SEEDS = range(60)


def drawn(kind, seed):
    """A noisy patch of a shape, 8 to 18 mm wide, sometimes with outliers."""
    rng = np.random.default_rng(seed)
    half, many = rng.uniform(4e-3, 9e-3), rng.choice([6, 8, 12])
    x, y = (at.ravel() for at in np.meshgrid(*[np.linspace(-half, half, many)] * 2))
    radius, turn = rng.uniform(1.6, 8.0) * half, rng.uniform(0.0, np.pi)
    aside = {"sphere": np.hypot(x, y), "cylinder": x * np.cos(turn) + y * np.sin(turn)}
    if kind == "cone":
        z = -rng.uniform(0.1, 1.0) * np.hypot(x - rng.uniform(-0.5, 0.5) * half, y)
    elif kind == "plane":
        z = rng.uniform(-0.3, 0.3) * x
    else:
        z = np.sqrt(radius**2 - aside[kind] ** 2) - radius
    z = z + rng.normal(0.0, rng.choice([2e-5, 1e-4, 3e-4]), x.shape)
    z += (rng.random(x.shape) < 0.1 * (rng.random() < 0.5)) * rng.uniform(-2e-3, 2e-3, x.shape)
    return sighted(np.stack([x, y, z], axis=1), None, None, name=kind, least=4)


@pytest.mark.parametrize("kind", ["plane", "sphere", "cylinder", "cone"])
def test_fits_of_the_right_shape_settle(kind):
    settled = [FITTERS[kind].settle(drawn(kind, seed)) for seed in RNG_SEEDS]
    assert max(found.moving for found in settled) < CLOSE


def test_a_shape_that_still_moves_is_refused_with_what_to_do():
    found = settle_cone(drawn("cone", 0))
    found.check("cone")
    with pytest.raises(IllConditioned, match=r"the cone does not settle .* 0\.92 of .* fit another shape"):
        dataclasses.replace(found, moving=0.92).check("cone")
