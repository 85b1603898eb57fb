from itertools import pairwise

import pytest

from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.objects.balloon import SECANT_DROP, BalloonObject
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.scene import load_scene
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


def test_of_a_pudding_the_settled_stiffness_is_known_and_a_fast_press_feels_more():
    spec = balloon("pudding")
    thing = specimen(spec, "viscosity")
    assert thing.memory == pytest.approx(0.05)
    assert thing.known(thing.start(), 0.0) == pytest.approx(
        {"radius": spec.radius, "stiffness": spec.secant()}, rel=1e-4
    )
    assert thing.law(thing.start(), 0.0)(SECANT_DROP)[0] > 1.2 * spec.law(SECANT_DROP)[0]


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
