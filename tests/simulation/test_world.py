import math

import pytest

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.model import hertz_force
from stretch_bt.simulation.membrane.hertz import HertzMembrane
from stretch_bt.simulation.scene import load_scene
from stretch_bt.simulation.world import World

TOP = 0.060


@pytest.fixture
def water():
    return World(load_scene("water_balloon"))


def test_nothing_touches_above_the_top(water):
    truth = water.truth(Pose((0, 0, TOP)), 0.02)
    assert (truth["force"], truth["depth"], truth["deflection"]) == (0.0, 0.0, 0.0)
    assert truth["height"] == truth["contact_height"] == TOP


@pytest.mark.parametrize("stretch", [0.0, 0.03, 0.08])
@pytest.mark.parametrize("travel", [1e-4, 0.005, 0.015])
def test_truth_is_consistent(water, stretch, travel):
    truth = water.truth(Pose((0.001, -0.002, TOP - travel)), stretch)
    assert truth["stiffness"] == pytest.approx(900)
    assert truth["force"] / truth["deflection"] == pytest.approx(900, rel=1e-9)
    assert truth["depth"] + truth["deflection"] == pytest.approx(travel)
    assert truth["height"] == pytest.approx(TOP - truth["deflection"])
    modulus, _ = HertzMembrane()._model.modulus(0.03, stretch)
    assert truth["force"] == pytest.approx(hertz_force("sphere", truth["depth"], modulus, radius=0.03))


def test_a_rigid_object_has_no_stiffness():
    world = World(load_scene("calibration_sphere"))
    truth = world.truth(Pose((0, 0, world.object.top - 0.01)), 0.03)
    assert "stiffness" not in truth
    assert (truth["deflection"], truth["depth"]) == pytest.approx((0.0, 0.01))
    assert all(math.isfinite(v) for v in truth.values())


def test_force_rises_with_depth_and_stretch(water):
    forces = [[water.contact(Pose((0, 0, TOP - d)), x).force for d in (0.002, 0.006, 0.012)] for x in (0, 0.04, 0.08)]
    assert all(row == sorted(row) for row in forces)
    assert all(list(column) == sorted(column) for column in zip(*forces, strict=True))


def test_one_solution_for_each_state(water):
    pose = Pose((0, 0, TOP - 0.01))
    assert water.contact(pose, 0.02) is water.contact(pose, 0.02)
    assert water.contact(pose, 0.03) is not water.contact(pose, 0.02)


def test_the_hand_turns_about_its_axis(water):
    """Seen from a hand turned by 90 degrees, an object to the side is ahead; membrane y runs against the hand's."""
    plain = water.contact(Pose((-0.01, 0, TOP - 0.005)), 0.0).axis
    turned = water.contact(Pose((-0.01, 0, TOP - 0.005), (0, 0, math.pi / 2)), 0.0).axis
    assert plain == pytest.approx((0.01, 0.0), abs=1e-12)
    assert turned == pytest.approx((0.0, 0.01), abs=1e-12)


@pytest.mark.parametrize(
    ("pose", "stretch", "said"),
    [
        (Pose((0, 0, TOP - 0.005), (0.1, 0, 0)), 0.0, "tilted"),
        (Pose((0.05, 0, TOP - 0.005)), 0.0, "border"),
        (Pose((0, 0, TOP - 0.005)), 0.09, "stretch of 90 mm"),
        (Pose((0, 0, TOP - 0.005)), -0.01, "stretch of -10 mm"),
    ],
)
def test_what_hertz_cannot_answer_is_refused(water, pose, stretch, said):
    good = Pose((0, 0, TOP - 0.004))
    before = water.contact(good, 0.0)
    with pytest.raises(NoEquilibrium, match=said):
        water.contact(pose, stretch)
    assert water.contact(good, 0.0) is before


def test_beside_the_object_nothing_touches(water):
    assert water.contact(Pose((0.2, 0, 0.01)), 0.0).depth == 0.0
