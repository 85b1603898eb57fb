import math
from itertools import pairwise

import pytest

from stretch_bt.errors import NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.objects.balloon import SECANT_DROP, BalloonObject
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World

FILLS = ("air", "water", "pudding", "seeds")
OWN = ("gas_compressibility", "latex_softening", "granular_hysteresis", "viscosity", "flattening")


def balloon(fill="water", pressure="4 kPa", diameter="60 mm", **more):
    given = {"type": "balloon", "diameter": diameter, "base": "30 mm", "pressure": pressure, "fill": {"type": fill}}
    return BalloonObject.model_validate({**given, **more})


def specimen(spec, *names):
    known = registry()
    return spec.specimen(Active(known[n](known[n].Parameters()) for n in known if n in ("compliance", *names)))


@pytest.mark.parametrize("drop", [1.0e-3, 1.5e-3, 2.0e-3, 2.5e-3, 3.0e-3])
def test_neighbouring_balloons_differ_by_1_3(drop):
    found = [load_scene(f"{fill}_balloon").object.secant(drop) for fill in FILLS]
    assert all(b / a >= 1.3 for a, b in pairwise(found))


@pytest.mark.parametrize("fill", FILLS)
@pytest.mark.parametrize("pressure", ["0.01 Pa", "2 Pa", "0.5 kPa", "2 kPa", "4 kPa", "10 kPa"])
@pytest.mark.parametrize("diameter", ["20 mm", "60 mm", "80 mm"])
def test_the_force_rises_from_nothing_to_the_cap_s_height(fill, pressure, diameter):
    if diameter == "20 mm" and pressure in ("4 kPa", "10 kPa"):
        pressure = "3.7 kPa"  # the most that so small a balloon may have
    spec = balloon(fill, pressure, diameter)
    response = specimen(spec, "gas_compressibility").response
    forces = [response.law(None, 0.0)(x * spec.radius) for x in (-0.1, 0.0, 1e-3, 0.01, 0.05, 0.2, 0.5, 0.99)]
    assert forces[0] == forces[1] == (0.0, 0.0)
    assert all(b[0] >= a[0] for a, b in pairwise(forces))
    assert all(math.isfinite(f) and math.isfinite(k) and k >= 0 for f, k in forces)


@pytest.mark.parametrize("model", ["linear", "table", "axisymmetric"])
def test_every_model_has_the_stiffness_at_the_drop_of_palpation(model):
    assert balloon(model=model).secant() == pytest.approx(balloon().secant(), rel=0.005)


def test_the_solver_goes_on_past_the_limit_as_a_power_law():
    law = balloon(model="axisymmetric", elements=24)
    force, slope = law.skin(law.limit)
    beyond = law.skin(1.2 * law.limit)[0]
    assert beyond == pytest.approx(force * 1.2 ** (slope * law.limit / force))


@pytest.mark.parametrize("fill", FILLS)
def test_a_slack_balloon_gives_way_without_a_force(fill):
    spec = balloon(fill, "0 Pa")
    thing = specimen(spec, "flattening", "latex_softening")
    if fill != "pudding":  # whose gel stands by itself
        assert thing.law(thing.start(), 0.0)(5e-3) == (0.0, 0.0)
    assert thing.standing(None, 5e-3).top == pytest.approx(spec.top - 5e-3)
    with pytest.raises(NoEquilibrium):
        thing.standing(None, spec.radius)


def test_the_hand_may_not_reach_the_rim():
    spec = balloon()
    thing = specimen(spec)
    thing.standing(None, 0.99 * spec.limit)
    with pytest.raises(NoEquilibrium, match="rim"):
        thing.standing(None, 1.01 * spec.limit)


@pytest.mark.parametrize("fill", FILLS)
def test_the_top_flattens_only_where_the_effect_is_on(fill):
    spec = balloon(fill)
    kept, flat = specimen(spec), specimen(spec, "flattening")
    assert kept.standing(None, SECANT_DROP).body == spec.body()
    radii = [flat.standing(None, d).body.tip_radius for d in (0.0, 0.5e-3, 1.5e-3, 4e-3)]
    assert radii[0] == spec.radius
    assert radii == sorted(radii)
    assert 1.05 < radii[2] / spec.radius < 1.4


def test_of_a_pudding_the_settled_stiffness_is_known_and_a_fast_press_feels_more():
    spec = balloon("pudding")
    thing = specimen(spec, "viscosity")
    assert thing.memory == pytest.approx(0.05)
    assert thing.known(thing.start(), 0.0) == pytest.approx(
        {"radius": spec.radius, "stiffness": spec.secant()}, rel=1e-4
    )
    assert thing.law(thing.start(), 0.0)(SECANT_DROP)[0] > 1.2 * spec.law(SECANT_DROP)[0]


def test_pressed_seeds_stay_down():
    thing = specimen(balloon("seeds"), "granular_hysteresis")
    pressed = thing.after(thing.start(), Moved(1.5e-3, (0.0, 0.0, -1.6), (0.0, 0.0), 1.0, 0.01))
    assert thing.rest(pressed, 0.0) == pytest.approx(1.0e-3)
    assert thing.kinks(pressed) == (1.5e-3,)
    assert thing.memory == math.inf


@pytest.mark.parametrize(
    ("fill", "name"),
    [
        ("water", "viscosity"),
        ("air", "granular_hysteresis"),
        ("seeds", "gas_compressibility"),
        ("seeds", "latex_softening"),
    ],
)
def test_an_effect_that_the_fill_cannot_have_is_an_error_at_its_line(fill, name):
    text = (
        "format: stretch-scene/1\n"
        f"object: {{type: balloon, diameter: 60 mm, pressure: 4 kPa, fill: {{type: {fill}}}}}\n"
        f"effects:\n  {name}: on\n"
    )
    with pytest.raises(SceneError, match=f"filled with {fill}") as caught:
        parse_scene(text)
    assert (caught.value.diagnostics[0].line, caught.value.diagnostics[0].column) == (4, 3)


@pytest.mark.parametrize("name", OWN)
def test_a_sphere_has_none_of_a_balloon_s_effects(name):
    assert "no" in registry()[name].refusal(load_scene("calibration_sphere").object)


def stiffness_size(fill, name):
    scene = load_scene(f"{fill}_balloon")
    effect = registry()[name]
    sizes = effect.sizes(Case(scene, scene.object.rough()), effect.Parameters())
    return next(s.value for s in sizes if s.observable == "stiffness")


def test_the_estimate_of_a_gas_is_what_the_gas_does():
    spec = load_scene("air_balloon").object
    soft = specimen(spec, "gas_compressibility").law(None, 0.0)(SECANT_DROP)[0]
    actual = 1 - soft / spec.law(SECANT_DROP)[0]
    assert stiffness_size("air", "gas_compressibility") == pytest.approx(actual, rel=0.3)


def test_the_estimate_of_a_gel_is_what_a_press_leaves():
    scene = load_scene("pudding_balloon")
    spec, conditions = scene.object, scene.conditions
    thing, state = specimen(spec, "viscosity"), None
    state, dt = thing.start(), 0.05
    press, hold = conditions.depth / conditions.speed, conditions.hold
    for k in range(1, round((press + hold) / dt) + 1):
        drop = SECANT_DROP * min(k * dt / press, 1.0)
        state = thing.after(state, Moved(drop, (0.0, 0.0, 0.0), (0.0, 0.0), dt, 0.0))
    actual = thing.law(state, 0.0)(SECANT_DROP)[0] / spec.law(SECANT_DROP)[0] - 1
    assert 0.5 < stiffness_size("pudding", "viscosity") / actual < 2


@pytest.mark.parametrize(
    ("fill", "name"), [("air", "gas_compressibility"), ("pudding", "viscosity"), ("water", "flattening")]
)
def test_an_effect_without_a_compliance_makes_no_response(fill, name):
    known = registry()
    assert balloon(fill).specimen(Active([known[name](known[name].Parameters())])).response is None


@pytest.mark.parametrize("fill", FILLS)
def test_a_shipped_balloon_says_what_it_assumes(fill):
    scene = load_scene(f"{fill}_balloon")
    assert "Assumed" in scene.doc
    assert scene.object.top == pytest.approx(0.060)
    assert scene.support.rim == pytest.approx(scene.object.base)


@pytest.mark.parametrize("fill", FILLS)
def test_in_the_world_force_over_drop_is_its_stiffness(fill):
    scene = load_scene(f"{fill}_balloon").with_(fidelity="hertz", effects="none")
    pose = Pose((0.0, 0.0, scene.object.top - 0.010))
    stiff = World(scene).truth(pose, 0.0)
    assert stiff["deflection"] == 0.0
    truth = World(scene.with_(effects="all")).truth(pose, 0.0)
    assert 0.2e-3 < truth["deflection"] < 5e-3
    if fill in ("air", "water"):  # the others depend on time and path
        assert truth["force"] / truth["deflection"] == pytest.approx(truth["stiffness"], rel=1e-6)
