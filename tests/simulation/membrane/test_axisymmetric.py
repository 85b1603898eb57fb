import pytest

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane import axisymmetric
from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.materials import MooneyRivlin, NeoHookean

# a stretch of 1.2 is tested at another scale below
OPEN_VALUES = [
    (1.0, 0.3, 0.12680261),
    pytest.param(1.2, 0.3, 0.54221102, marks=pytest.mark.slow),
    pytest.param(1.5, 0.6, 1.21905393, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("prestretch", "depth", "force"), OPEN_VALUES)
def test_known_forces(prestretch, depth, force):
    press = CircularMembrane(1.0, 1.0, NeoHookean(1.0), prestretch).press(0.2, depth)
    assert press.force == pytest.approx(force, rel=1e-7)
    assert press.residual < 1e-10
    assert press.profile[0] == pytest.approx([0.0, depth], abs=1e-5)
    assert press.profile[-1] == pytest.approx([1.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(
    "material", [pytest.param(NeoHookean(1.0), marks=pytest.mark.slow), MooneyRivlin(1.0, 0.2)], ids=repr
)
def test_force_is_the_derivative_of_the_energy(material):
    membrane = CircularMembrane(1.0, 1.0, material, 1.2)
    below, above = (membrane.press(0.2, 0.3 + step).energy for step in (-2e-4, 2e-4))
    assert membrane.press(0.2, 0.3).force == pytest.approx((above - below) / 4e-4, rel=1e-6)


def test_force_scales_with_modulus_thickness_and_size():
    small = CircularMembrane(0.05, 0.002, NeoHookean(40e3), 1.2).press(0.01, 0.015)
    assert small.force == pytest.approx(0.54221102 * 40e3 * 0.002 * 0.05, rel=1e-7)


@pytest.mark.hard
@pytest.mark.parametrize("rates", [5_000, pytest.param(axisymmetric._MOST_RATES, marks=pytest.mark.slow)])
def test_a_press_that_cannot_be_shot_is_given_up(monkeypatch, rates):
    monkeypatch.setattr(axisymmetric, "_MOST_RATES", rates)
    with pytest.raises(NoEquilibrium, match="press deeper"):
        CircularMembrane(0.05, 0.002, NeoHookean(47.4e3)).press(0.01, 1e-6)
