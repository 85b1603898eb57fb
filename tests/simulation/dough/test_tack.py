"""Dough that sticks to the hand: what it does to a hand that rises, and when it comes along."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.hanging import Grip, between, pulled_by
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.scene import parse_scene
from stretch_bt.simulation.world import World

WEIGHT = 0.1916  # N, of 25 mm of dough
SCENE = """\
format: stretch-scene/1
object: {type: dough}
hand: {frame: 12 mm}
tolerance: {roundness: 1 %, height: 0.5 mm}
conditions: {stretch: 60 mm, depth: 5 mm, hold: 0 s, speed: 30 mm/s, frames: 1, travel: 2 m}
"""
# effects, stretch, and whether it comes along
CASES = {
    "off": ("tack: off", 0.0, False),
    "as it is": ("tack: on", 0.0, False),
    "on flour": ("tack: {pull: 0.25 N, hold: 0 N}", 0.0, True),
    "a table that holds it": ("tack: {pull: 0.25 N, hold: 0.1 N}", 0.0, False),
    "strong": ("tack: {pull: 0.5 N}", 0.0, True),
    "strong, under a tense membrane": ("tack: {pull: 0.5 N}", 0.06, True),
    "strong, under one that hangs": ("tack: {pull: 0.5 N}, sag: on", 0.0, True),
    "strong, under one that softens": ("tack: {pull: 0.5 N}, mullins: on", 0.02, True),
    "between two stretches that are solved": ("tack: {pull: 0.5 N}", 0.0437, True),
}


def led(effects, stretch, *path):
    """Lead a hand through (x, height), m, over the cube; return the world, and the contact and the truth at the end."""
    world, time = World(parse_scene(f"{SCENE}effects: {{{effects}}}\n")), 0.0
    for x, z in path:
        time += 0.1
        pose = Pose((x, 0.0, z))
        world.advance(pose, stretch, time)
    return world, world.contact(pose, stretch, time), world.truth(pose, stretch, time)


#: "strong" under another membrane
OTHERS = ("strong, under a tense membrane", "strong, under one that hangs", "strong, under one that softens")


@pytest.mark.parametrize("case", [pytest.param(c, marks=[pytest.mark.slow] * (c in OTHERS)) for c in CASES])
def test_it_comes_along_where_the_hand_holds_it_harder_than_table_and_weight(case):
    effects, stretch, comes = CASES[case]
    world, contact, truth = led(effects, stretch, (0.0, 0.024), (0.0, 0.035), (0.02, 0.035))
    lowest = world.skin(contact, stretch).points[..., 2].min()
    assert (world.specimen.grip(world._past[-1].thing) is not None) == comes
    assert truth["depth"] == 0.0, "the hand is above it"
    if not comes:
        assert contact.force == (0.0, 0.0, 0.0)
        assert truth["height"] == pytest.approx(0.025, abs=5e-4)
        assert lowest == pytest.approx(0.0, abs=1e-5)
        return
    assert contact.force == pytest.approx((0.0, 0.0, -WEIGHT), abs=1e-3)
    assert lowest == pytest.approx(truth["height"] - 0.035, abs=2e-4), (
        "its top is where the membrane is lowest, but for its bend"
    )
    assert world._past[-1].thing.lump.x == pytest.approx(0.02), "it goes with the hand"
    assert world.standing().top == pytest.approx(truth["height"], abs=5e-4)


def test_a_hand_that_rises_is_pulled_ever_harder_up_to_what_the_bond_bears():
    heights = [0.0253, 0.0256, 0.0259, 0.030]
    forces = [led("tack: on", 0.0, (0.0, 0.024), (0.0, z))[1].force[2] for z in heights]
    assert 0 > forces[0] > forces[1] > forces[2] > -0.1
    assert forces[3] == 0


def test_what_was_let_go_has_to_be_touched_again():
    free = led("tack: on", 0.0, (0.0, 0.024), (0.0, 0.030), (0.0, 0.0255))[1]
    assert free.force == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("across", [((0.03, 0.040),), ()], ids=["over it first", "in one step"])
def test_it_is_put_down_where_the_hand_goes_down(across):
    world, contact, truth = led("tack: {pull: 0.5 N}", 0.06, (0.0, 0.024), (0.0, 0.040), *across, (0.03, 0.023))
    assert contact.force[2] > 0
    assert truth["height"] < 0.0255
    assert world._past[-1].thing.lump.x == pytest.approx(0.03)
    line = np.array(world.sketch(world.latest)["side"])
    assert line[:, 1].min() == pytest.approx(0.0, abs=1e-9)


def test_a_sketch_shows_it_in_the_air():
    world, _, truth = led("tack: {pull: 0.5 N}", 0.06, (0.0, 0.024), (0.0, 0.040))
    assert np.array(world.sketch(world.latest)["side"])[:, 1].max() == pytest.approx(truth["height"], abs=5e-4)


@pytest.mark.parametrize(
    ("effects", "on", "least", "why"),
    [
        ("", False, 0.0, "pull over force"),
        ("tack: {pull: 0.5 N}", True, 0.03, "comes along: pull 0.5 N, held by 0.29 N"),
        ("tack: {pull: 0.5 N, hold: 0.4 N}", True, 0.0, "pull over force"),
    ],
)
def test_the_advisor_says_that_it_comes_along(effects, on, least, why):
    (verdict,) = [v for v in advise(parse_scene(f"{SCENE}effects: {{{effects}}}\n")) if v.name == "tack"]
    assert verdict.on == on
    assert why in verdict.why
    assert verdict.estimate >= least


def test_only_the_sheet_can_be_pulled_down():
    scene = parse_scene(f"{SCENE}fidelity: hertz\neffects: auto\n")
    (verdict,) = [v for v in advise(scene) if v.name == "tack"]
    assert not verdict.on
    assert "hertz fidelity" in verdict.why


def spring(way):
    return 100.0 * way, 100.0


@given(
    pull=st.floats(0.0, 2.0),
    weight=st.floats(0.0, 1.0),
    hold=st.floats(0.0, 1.0),
    above=st.floats(0.0, 1.0),
    raised=st.sampled_from([0.0, 0.01]),
)
def test_no_bond_bears_more_than_it_can(pull, weight, hold, above, raised):
    grip = Grip(pull, weight, hold, Cylinder(0.015), raised if pull > weight + hold else 0.0)
    found = pulled_by(spring, grip, above)
    if found is None:
        assert not grip.lifts
        assert 100.0 * above >= min(pull, weight + hold) - 1e-9
        return
    assert found.force <= min(pull, weight + hold) + 1e-6
    assert found.force == pytest.approx(100.0 * found.down, abs=1e-6)
    assert found.down + found.raised == pytest.approx(above)
    assert 0 <= found.raised <= above
    assert not found.raised or (grip.lifts and found.force == weight)


def test_a_membrane_that_has_no_answer_says_so():
    def torn(way):
        raise NoEquilibrium("torn")

    with pytest.raises(NoEquilibrium, match="torn"):
        pulled_by(torn, Grip(1.0, 0.1, 0.1, Cylinder(0.015)), 0.01)


@pytest.mark.parametrize("stretch", [0.0, 0.004, 0.01, 0.0799999999, 0.08])
def test_a_law_between_stretches_is_a_straight_line(stretch):
    law = between(stretch, lambda known: lambda way: (known * way, known))
    assert law(2.0) == pytest.approx((2 * stretch, stretch))
