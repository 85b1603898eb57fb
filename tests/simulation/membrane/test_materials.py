import numpy as np
import pytest
from hypothesis import given, settings

from stretch_bt.hardcases.strategies.membrane import PRINCIPAL
from stretch_bt.simulation.membrane.materials import Material, MooneyRivlin, NeoHookean, rubber
from stretch_bt.simulation.membrane.materials.base import energy, tensions
from stretch_bt.simulation.membrane.sheet.energy_kernel import strain_energy

MATERIALS = [NeoHookean(40e3), MooneyRivlin(40e3, 0.15), MooneyRivlin(40e3, 1.0)]
LAWS = {"plain": (1.0, 0.0, 0.0, 0.0), "wrinkling": (1e-3, 0.0, 0.0, 0.0), "mullins": (1.0, 2.0, 0.05, 0.1)}


@pytest.mark.parametrize("material", MATERIALS, ids=repr)
@given(PRINCIPAL, PRINCIPAL)
@settings(max_examples=30, deadline=None)
def test_tensions_are_derivatives_of_the_energy(material, l1, l2):
    h = 1e-5
    n1, n2, a11, a12 = tensions(material, l1, l2)
    assert n1 == pytest.approx((energy(material, l1 + h, l2) - energy(material, l1 - h, l2)) / (2 * h), abs=1e-7)
    assert n2 == pytest.approx((energy(material, l1, l2 + h) - energy(material, l1, l2 - h)) / (2 * h), abs=1e-7)
    for value, at in ((a11, (h, 0)), (a12, (0, h))):
        above, below = tensions(material, l1 + at[0], l2 + at[1])[0], tensions(material, l1 - at[0], l2 - at[1])[0]
        assert value == pytest.approx((above - below) / (2 * h), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("material", MATERIALS, ids=repr)
def test_both_solvers_know_the_same_material_and_its_modulus(material):
    assert isinstance(material, Material)
    law = np.array([*material.coefficients, 1.0, 0.0, 0.0, 0.0])
    for l1, l2 in ((1.0, 1.0), (1.3, 0.9), (2.0, 1.5)):
        assert strain_energy(l1**2 + l2**2, (l1 * l2) ** 2, 0.0, law)[0] == pytest.approx(energy(material, l1, l2))
    small = 1e-4
    assert energy(material, 1 + small, 1 / (1 + small)) / (2 * small**2) == pytest.approx(1.0, rel=1e-3)  # W = mu g^2/2


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("material", MATERIALS, ids=repr)
@given(PRINCIPAL, PRINCIPAL)
@settings(max_examples=30, deadline=None)
def test_kernel_derivatives(material, law, l1, l2):
    parameters = np.array([*material.coefficients, *LAWS[law]])
    t, j, h = l1**2 + l2**2, (l1 * l2) ** 2, 1e-5
    low, high = sorted((l1, l2))
    if law == "wrinkling" and (high - low < 0.05 or abs(low * high**0.5 - 1) < 0.01 or abs(high - 1) < 0.01):
        return  # at the onset of wrinkles the second derivatives jump

    def at(dt, dj):
        return np.array(strain_energy(t + dt, j + dj, 3.0, parameters))

    values = at(0, 0)
    by_t, by_j = (at(h, 0) - at(-h, 0)) / (2 * h), (at(0, h) - at(0, -h)) / (2 * h)
    np.testing.assert_allclose([by_t[0], by_j[0]], values[1:3], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose([by_t[1], by_t[2], by_j[2]], values[3:], rtol=1e-4, atol=1e-5)


def test_a_tension_field_carries_no_compression():
    law = np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert strain_energy(0.9**2 + 0.8**2, (0.9 * 0.8) ** 2, 0.0, law)[0] == 0.0
    narrow = [strain_energy(1.5**2 + w**2, (1.5 * w) ** 2, 0.0, law)[0] for w in (0.5, 0.7, 1.5**-0.5)]
    assert narrow == pytest.approx([narrow[2]] * 3)
    assert narrow[2] == pytest.approx(0.5 * (1.5**2 + 2 / 1.5 - 3))


def test_a_rubber_without_the_second_invariant_is_neo_hookean():
    assert rubber(40e3) == rubber(40e3, 0.0) == NeoHookean(40e3)
    assert rubber(40e3, 0.15) == MooneyRivlin(40e3, 0.15)
