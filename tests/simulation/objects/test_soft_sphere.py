"""A soft sphere: its law, its truth at a deflection, and a gel that relaxes."""

import math

import pytest

from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.effects.compliance import Compliance
from stretch_bt.simulation.effects.viscosity import Viscosity
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.scene import parse_scene

SCENE = """format: stretch-scene/1
object: {{type: soft_sphere, diameter: 60 mm, stiffness: 0.4 N/mm, {more}}}
tolerance: {{stiffness: 5 %}}
"""


def ball(more):
    return parse_scene(SCENE.format(more=more)).object


@pytest.mark.parametrize("power", [0.8, 1.0, 1.5, 2.2])
@pytest.mark.parametrize("drop", [1e-4, 1.5e-3, 4e-3])
def test_force_and_slope_are_those_of_the_power_law(power, drop):
    law = ball(f"power: {power}").law
    force, slope = law(drop)
    assert force == pytest.approx(0.6 * (drop / 1.5e-3) ** power)
    assert slope == pytest.approx((law(drop + 1e-9)[0] - law(drop - 1e-9)[0]) / 2e-9, rel=1e-5)
    assert law(0.0)[0] == law(-1e-3)[0] == 0.0


def test_the_truth_is_the_secant_at_the_deflection_that_it_has():
    specimen = ball("power: 1.5").specimen(Active((Compliance(Compliance.Parameters()),)))
    assert specimen.known(specimen.start(), 0.0)["stiffness"] == pytest.approx(400.0)
    assert specimen.known(specimen.start(), 6e-3)["stiffness"] == pytest.approx(800.0)


def test_a_gel_answers_a_sudden_push_harder_and_relaxes():
    spec = ball("power: 1.5, sudden: 1, time: 2 s")
    effects = Active((Compliance(Compliance.Parameters()), Viscosity(Viscosity.Parameters())))
    specimen = spec.specimen(effects)
    state, relaxed = specimen.start(), spec.law(2e-3)[0]
    assert specimen.law(state, 1e-6)(2e-3)[0] == pytest.approx(2 * relaxed, rel=1e-5)
    state = specimen.after(state, Moved(2e-3, (0.0, 0.0, 0.0), (0.0, 0.0), 1e-6, 2e-3))
    for _ in range(40):
        state = specimen.after(state, Moved(2e-3, (0.0, 0.0, 0.0), (0.0, 0.0), 0.05, 2e-3))
    assert specimen.law(state, 1e-9)(2e-3)[0] == pytest.approx((1 + math.exp(-1)) * relaxed, rel=1e-3)


@pytest.mark.parametrize(("more", "on"), [("sudden: 1", True), ("sudden: 0", False)])
def test_the_advisor_switches_viscosity_on_where_it_changes_the_stiffness(more, on):
    verdicts = {verdict.name: verdict for verdict in advise(parse_scene(SCENE.format(more=more)))}
    assert verdicts["viscosity"].on is on
    assert verdicts["compliance"].on
