"""Cases that break membrane solvers, each with the outcome that it must have."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from stretch_bt.errors import Impossible, NoEquilibrium
from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.sheet.settings import Settings

USUAL = {"indenter": "sphere:20mm", "stretch": 0.03, "depth": 0.010}
FINER = Settings(coarsen=0.7)


class Hard(NamedTuple):
    """What differs from the usual press, the reason if it must be refused, and the warning if one must be given."""

    options: dict
    refused: str = ""
    warns: str = ""


CASES = {
    "stretch exactly 0": Hard({"stretch": 0.0, "depth": 0.005}),
    "stretch 0, hardly touched": Hard({"stretch": 0.0, "depth": 0.2e-3}, warns="finer mesh"),
    "stretch 0, no compression": Hard({"stretch": 0.0, "depth": 0.005, "effects": ["wrinkling"]}),
    "stretch 0, hanging": Hard({"stretch": 0.0, "depth": 0.010, "effects": ["sag"]}),
    "stretch 0, flat cylinder": Hard({"stretch": 0.0, "depth": 0.005, "indenter": "cylinder:20mm"}),
    "stretch 0, 1 um": Hard({"stretch": 0.0, "depth": 1e-6}, refused="rounding"),
    "1 um": Hard({"depth": 1e-6}),
    "15 mm in one step": Hard({"depth": 0.015}),
    "tip past its radius in one step": Hard({"indenter": "sphere:10mm", "stretch": 0.06, "depth": 0.015}),
    "needle": Hard({"indenter": "sphere:0.5mm", "depth": 0.5e-3}),
    "needle, too deep": Hard({"indenter": "sphere:0.5mm", "depth": 0.005}, refused="limit point"),
    "flat cylinder": Hard({"indenter": "cylinder:20mm"}),
    "cone": Hard({"indenter": "cone:45deg", "depth": 0.005}),
    "cone too sharp for its mesh": Hard({"indenter": "cone:80deg", "depth": 0.005}, refused="stands out"),
    "large face": Hard({"indenter": "cube:40mm"}),
    "wire deeper than it is thick": Hard({"indenter": Wire(0.0015, 0.2), "depth": 0.008}),
    "half over the free edge": Hard({"indenter": "cone:45deg", "at": (0.037, 0.0), "depth": 0.006}),
    "tilted": Hard({"indenter": "cylinder:20mm", "tilt": (0.3, 0.1)}),
    "between two elements": Hard({"at": (0.7e-3, 0.4e-3)}),
    "over the free edge": Hard({"at": (0.040, 0.0)}),
    "beside the clamp": Hard({"at": (0.0, 0.055)}),
    "over the clamp": Hard({"at": (0.0, 0.060)}, refused="clamp"),
    "at the free edge": Hard({"at": (0.036, 0.0)}),
    "beside the sheet": Hard({"at": (0.2, 0.0)}, refused="does not reach"),
    "past the limit point": Hard({"indenter": "sphere:8mm", "stretch": 0.08, "depth": 0.020}, refused="limit point"),
    "far past the limit point": Hard({"indenter": "sphere:8mm", "stretch": 0.08, "depth": 0.06}, refused="limit point"),
    "just before the limit point": Hard({"indenter": "sphere:8mm", "depth": 0.022}),
    "modulus x 1e-6": Hard({"shear_modulus": 47.4e-3}),
    "modulus x 1e6": Hard({"shear_modulus": 47.4e9}),
    "mesh coarser than the contact": Hard({"mesh": 0.008, "depth": 0.002}, warns="finer mesh"),
    "little budget": Hard({"settings": Settings(budget=60)}),
    "no budget": Hard({"settings": Settings(budget=3)}, refused="iterations"),
}


#: each costs a second or more, and is like another in what it asks of the solver
COSTLY = (
    "stretch 0, flat cylinder",
    "stretch 0, hardly touched",
    "stretch 0, no compression",
    "1 um",
    "needle, too deep",
    "half over the free edge",
    "past the limit point",
    "modulus x 1e-6",
)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in COSTLY else n for n in CASES])
def test_hard_cases(name):
    case = CASES[name]
    options = USUAL | case.options
    if case.refused:
        with pytest.raises(NoEquilibrium) as caught:
            press(**options)
        assert case.refused in caught.value.reason
        return
    found = press(**options)
    assert found.force > 0
    assert found.balance < 1e-6
    assert all(math.isfinite(v) for v in (found.force_error, found.residual, found.contact.area))
    assert any(case.warns in w for w in found.warnings) if case.warns else not any("mesh" in w for w in found.warnings)
    finer = press(**options | {"mesh": None, "settings": FINER})
    assert abs(finer.force - found.force) <= 3 * found.force_error


def test_elements_of_ten_to_one():
    found = press("sphere:10mm", 0.03, 0.005, settings=Settings(growth=3.0))
    mesh = found.detail.shape.mesh
    assert np.diff(mesh.y.breaks).max() > 10 * np.diff(mesh.x.breaks).min()
    finer = press("sphere:10mm", 0.03, 0.005, settings=Settings(coarsen=0.5))
    assert abs(finer.force - found.force) <= 3 * found.force_error


def test_contact_lost_and_regained():
    before = press(**USUAL)
    with pytest.raises(Impossible):
        press(**USUAL | {"at": (0.2, 0.0)}, start=before)
    elsewhere = press(**USUAL | {"at": (-0.02, 0.03), "depth": 0.1e-3}, start=before)  # no point in common
    again = press(**USUAL, start=elsewhere)
    assert again.force == pytest.approx(before.force, rel=1e-3)
    assert again.balance < 1e-6


def test_a_stretch_carries_the_mesh_along():
    place = {"indenter": "sphere:10mm", "depth": 0.008, "at": (0.0, 0.03)}
    for settings in (Settings(), Settings.within(0.01)):
        start = press(stretch=0.005, settings=settings, **place)
        found = press(stretch=0.075, settings=settings, start=start, **place)
        assert found.force == pytest.approx(press(stretch=0.075, **place).force, rel=0.01)


def test_a_press_in_small_steps_and_back_retraces():
    depths = np.array([*range(2, 13, 2), *range(10, 1, -2)]) * 1e-3
    state, forces = None, []
    for depth in depths:
        state = press("sphere:20mm", 0.03, float(depth), start=state)
        forces.append(state.force)
    np.testing.assert_allclose(forces[:5], forces[:5:-1], rtol=1e-3)


def test_it_does_not_matter_where_the_elements_lie():
    mesh = Settings(mesh=2e-3, growth=1.0)
    forces = [press("sphere:20mm", 0.03, 0.008, at=(x, 0.0), settings=mesh).force for x in (0.0, 0.5e-3, 1e-3)]
    np.testing.assert_allclose(forces, forces[0], rtol=0.01)
