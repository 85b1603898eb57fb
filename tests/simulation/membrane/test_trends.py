import re
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.press import SHEAR_MODULUS
from stretch_bt.simulation.membrane.sheet.settings import Settings

FAST = Settings(exact=False, coarsen=1.25)
PAGE = Path(__file__).parents[3] / "docs" / "membrane.md"
MOUNT = re.compile(r"\| (\d+) mm \| 1 to (\d+) mm \| ([\d.]+) ± [\d.]+ kPa \| ([\d.]+) ± [\d.]+ mm \|")
MOUNTS = [tuple(float(v) for v in row) for row in MOUNT.findall(PAGE.read_text("utf-8"))]


def moduli(trends, indenter, gauge, pulls, fit_depth=10):
    return np.array([trends.effective_modulus(indenter, gauge, pull, fit_depth, FAST)[0] for pull in pulls])


@pytest.mark.parametrize(("gauge", "mount"), [pytest.param(0.100, 0.0, marks=pytest.mark.slow), (0.075, 0.012)])
def test_stiffness_rises_with_stretch_like_a_logarithm(trends, gauge, mount):
    stretch = np.linspace(0.0, 0.06, 7)
    found = moduli(trends, "sphere:20mm", gauge, (mount + stretch).tolist())
    assert (np.diff(found) > 0).all()
    x, taut = stretch[1:], found[1:]
    assert trends.linear_r2(np.log(x), taut) > trends.linear_r2(x, taut)
    assert trends.linear_r2(np.log(x), taut) > 0.985


@pytest.mark.parametrize("pull", [0.01, pytest.param(0.04, marks=pytest.mark.slow)])
def test_stiffness_falls_with_diameter_and_force_rises(trends, pull):
    shapes = [f"sphere:{d}mm" for d in (10, 15, 20, 25, 30)]
    found = np.array([trends.effective_modulus(s, 0.1, pull, 10, FAST)[0] for s in shapes])
    assert (np.diff(found) < 0).all()
    assert 0.60 < found[-1] / found[0] < 0.80
    assert (np.diff([trends.forces(s, 0.1, pull, FAST)[9] for s in shapes]) > 0).all()


def test_the_page_states_a_mount_for_both_gauges_and_each_fit_depth():
    assert [row[:2] for row in MOUNTS] == [(g, d) for g in (100, 75) for d in (5, 10, 15)]


@pytest.mark.parametrize(
    ("gauge", "fit_depth", "shear_modulus", "prestretch"),
    [pytest.param(*mount, marks=[pytest.mark.slow] * (number % 3 > 0)) for number, mount in enumerate(MOUNTS)],
)
def test_the_stated_mount_spans_4_to_9_kilopascal(trends, gauge, fit_depth, shear_modulus, prestretch):
    ends = moduli(trends, "sphere:20mm", gauge / 1e3, (prestretch / 1e3, prestretch / 1e3 + 0.06), int(fit_depth))
    np.testing.assert_allclose(ends * shear_modulus * 1e3 / SHEAR_MODULUS, [4e3, 9e3], rtol=0.02)


def test_only_the_sum_of_stretch_and_mount_counts():
    forces = [press("sphere:20mm", 0.03 - m, 0.01, mount_prestretch=m, settings=FAST).force for m in (0.0, 0.012)]
    assert forces[1] == pytest.approx(forces[0], rel=1e-9)


def test_a_flat_untensioned_mount_is_no_hertz_contact(trends):
    modulus, quality = trends.effective_modulus("sphere:20mm", 0.1, 0.0, 10)
    assert 0.25e3 < modulus < 0.45e3
    assert quality < 0.9
    forces = trends.forces("sphere:20mm", 0.1, 0.0)
    assert np.polyfit(np.log(np.arange(3, 16)), np.log(forces[2:]), 1)[0] == pytest.approx(3, abs=0.15)
