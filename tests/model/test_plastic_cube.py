import numpy as np
import pytest

from stretch_bt.model import cube_yield_stress
from stretch_bt.simulation.dough.lump import cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.resistance import Resistance
from stretch_bt.simulation.objects.dough import DoughObject
from stretch_bt.units import Estimate


def resistance(edge: float, strength: float, ratio: float) -> Resistance:
    spec = DoughObject(
        type="dough", edge=f"{1e3 * edge} mm", yield_stress=f"{strength} Pa", modulus=f"{ratio * strength} Pa"
    )
    lump = cube(spec.edge, spec.directions, spec.heading)
    return Resistance(lump, Dough(strength, ratio * strength, tension=spec.smoothing), spec.weight)


@pytest.mark.parametrize("edge", [0.020, 0.025, 0.030])
@pytest.mark.parametrize("strength", [0.9e3, 2e3, 5e3, 1e4])
@pytest.mark.parametrize("ratio", [14.0, 30.0])
def test_it_is_the_yield_stress_of_the_twins_cube_once_it_flows(edge: float, strength: float, ratio: float) -> None:
    felt = resistance(edge, strength, ratio)
    for strain in (0.10, 0.15, 0.20, 0.30, 0.38):
        force, _ = felt.force(strain * edge)
        height = Estimate((1 - strain) * edge, 0.0)
        found = cube_yield_stress(Estimate(force, 0.0), Estimate(edge, 0.0), height)
        assert abs(found.value - strength) < 2 * found.sd, strain


def test_its_deviation_is_that_of_draws() -> None:
    rng = np.random.default_rng(1)
    height = Estimate(0.0225, 0.0)
    found = cube_yield_stress(Estimate(4.5, 0.3), Estimate(0.025, 5e-4), height)
    drawn = [
        cube_yield_stress(Estimate(rng.normal(4.5, 0.3), 0.0), Estimate(rng.normal(0.025, 5e-4), 0.0), height).value
        * rng.normal(1, 0.0321)
        for _ in range(4000)
    ]
    assert np.std(drawn) == pytest.approx(found.sd, rel=0.05)
