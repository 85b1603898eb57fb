import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.model import ForceModel, hertz_force
from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.camera.renderer import DepthRenderer
from stretch_bt.simulation.camera.skin import table_under
from stretch_bt.simulation.camera.view import SR305
from stretch_bt.simulation.fidelity.rungs import RUNGS
from stretch_bt.simulation.objects.response import Response
from stretch_bt.simulation.objects.sphere import SphereObject
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World

TOP = 0.060


def scene(given="stiffness: 0.9 N/mm", kind="type: sphere, diameter: 60 mm", fidelity="hertz", effects="auto", more=""):
    thing = ", ".join(part for part in (kind, given) if part)
    return parse_scene(
        f"format: stretch-scene/1\nobject: {{{thing}}}\nfidelity: {fidelity}\neffects: {effects}\n{more}"
    )


def coarse(made):
    """Return the world of a scene with a coarse mesh, for tests in which what the sheet answers is no matter of its mesh."""
    return World(made, settings=RUNGS["coarse"])


@pytest.fixture
def soft():
    return World(scene())


def test_hertz_fidelity_is_the_calibrated_law(soft):
    truth = soft.truth(Pose((0, 0, TOP - 0.01)), 0.03)
    modulus, _ = ForceModel.default().modulus(0.03, 0.03)
    assert truth["force"] == pytest.approx(hertz_force("sphere", truth["depth"], modulus, radius=0.03))


@pytest.mark.parametrize("fidelity", ["hertz", "axisymmetric", "sheet"])
def test_a_rigid_object_has_no_stiffness(fidelity):
    world = World(scene("rigid: true", fidelity=fidelity, effects="{sag: off}"))
    truth = world.truth(Pose((0, 0, TOP - 0.01)), 0.03)
    assert "stiffness" not in truth
    assert (truth["deflection"], truth["depth"]) == pytest.approx((0.0, 0.01))
    assert all(math.isfinite(v) for v in truth.values())


@pytest.mark.parametrize(
    ("made", "effects"),
    [(scene(), "{compliance: off}"), (load_scene("water_balloon"), "none")],
    ids=["sphere", "balloon"],
)
def test_what_is_kept_from_giving_way_has_no_stiffness(made, effects):
    still = made.with_(fidelity="hertz", effects=scene(effects=effects).effects)
    for given, gives in ((made.with_(fidelity="hertz"), True), (still, False)):
        truth = World(given).truth(Pose((0, 0, given.object.top - 0.01)), 0.03)
        assert ("stiffness" in truth, truth["deflection"] > 0) == (gives, gives)


def test_the_true_force_is_what_nodes_measure_of_it():
    """Beside the middle the sheet pushes aside as well; that part of it was in the truth, and in no reading."""
    world = World(
        scene("rigid: true, position: {x: 28 mm, y: 30 mm}", "type: sphere, diameter: 20 mm", "sheet", "none")
    )
    pose = Pose((0, 0, 0.012))
    force = world.contact(pose, 0.03, 0.0).force
    assert math.hypot(*force[:2]) > 0.02 * force[2] > 0
    assert world.truth(pose, 0.03)["force"] == force[2]


@pytest.mark.parametrize("fidelity", ["hertz", "sheet"])
def test_force_rises_with_depth_and_stretch(fidelity):
    world = coarse(scene(fidelity=fidelity))
    forces = [
        [math.hypot(*world.contact(Pose((0, 0, TOP - d)), x).force) for d in (0.002, 0.006, 0.012)]
        for x in (0, 0.04, 0.08)
    ]
    assert all(row == sorted(row) for row in forces)
    assert all(list(column) == sorted(column) for column in zip(*forces, strict=True))


def rigid(diameter):
    return scene("rigid: true, base: 40 mm", kind=f"type: sphere, diameter: {diameter} mm").object


@pytest.mark.parametrize("fidelity", ["hertz", "sheet"])
def test_what_is_exchanged_is_met_as_from_the_begin(fidelity):
    effects = "{sag: on, bending: on}" if fidelity == "sheet" else "none"
    made = World(scene("rigid: true", fidelity=fidelity, effects=effects))
    pose = Pose((0, 0, 0.055))
    made.contact(pose, 0.02)
    made.exchange(rigid(20))
    fresh = World(
        scene("rigid: true, base: 40 mm", kind="type: sphere, diameter: 20 mm", fidelity=fidelity, effects=effects)
    )
    assert made.truth(pose, 0.02) == pytest.approx(fresh.truth(pose, 0.02), rel=1e-9)
    assert made.truth(pose, 0.02)["radius"] == 0.010


def test_a_soft_object_takes_its_own_effects_with_it(soft):
    soft.advance(Pose((0, 0, TOP - 0.01)), 0.0, 1.0)
    assert "compliance" in soft.effects
    soft.exchange(rigid(20))
    truth = soft.truth(Pose((0, 0, 0.055)), 0.0, 2.0)
    assert (truth["deflection"], truth["depth"]) == pytest.approx((0.0, 0.005))
    assert "stiffness" not in truth


def test_softening_stays_in_the_membrane_when_the_object_is_exchanged():
    above, low = Pose((0, 0, 0.100)), Pose((0, 0, 0.055))
    forces = []
    for before in (None, 0.0):
        made = World(
            scene(
                "rigid: true, base: 40 mm",
                kind="type: sphere, diameter: 30 mm",
                fidelity="sheet",
                effects="{mullins: on}",
            )
        )
        if before is not None:
            made.advance(Pose((0, 0, 0.065)), 0.03, 1.0)
            made.advance(above, 0.0, 2.0)
        made.exchange(rigid(20))
        forces.append(made.truth(low, 0.0, 3.0)["force"])
    assert forces[1] < 0.95 * forces[0]


def test_a_membrane_that_was_conditioned_begins_at_its_softest():
    ball, low = "type: sphere, diameter: 30 mm", Pose((0, 0, 0.060))
    forces = {}
    for effects in ("{mullins: on}", "{mullins: off}", "none"):
        for hand in ("", "hand: {conditioned: {diameter: 30 mm, stretch: 40 mm, depth: 10 mm}}\n"):
            made = coarse(scene("rigid: true, base: 40 mm", kind=ball, fidelity="sheet", effects=effects, more=hand))
            forces[effects, bool(hand)] = made.truth(low, 0.02)["force"]
    assert forces["{mullins: on}", True] < 0.95 * forces["{mullins: on}", False]
    assert forces["none", True] == forces["none", False]


def test_one_solution_for_each_state_and_none_until_somebody_looks():
    world = World(scene(fidelity="sheet"))
    pose = Pose((0, 0, TOP - 0.01))
    assert world.stats.counts == {}
    assert world.contact(pose, 0.02, 1.0) is world.contact(pose, 0.02, 2.0)
    assert world.contact(pose, 0.03) is not world.contact(pose, 0.02)
    assert world.stats.counts["contact"] == 2
    assert "shape" not in world.stats.counts
    skin = world.skin(world.contact(pose, 0.02), 0.02)
    assert world.skin(world.contact(pose, 0.02), 0.02) is skin
    assert (world.stats.counts["contact"], world.stats.counts["shape"]) == (2, 1)


def test_the_hand_turns_about_its_axis(soft):
    """Seen from a hand turned by 90 degrees, an object to the side is ahead; membrane y runs against the hand's."""
    plain = soft.contact(Pose((-0.01, 0, TOP - 0.005)), 0.0).place.at
    turned = soft.contact(Pose((-0.01, 0, TOP - 0.005), (0, 0, math.pi / 2)), 0.0).place.at
    assert plain == pytest.approx((0.01, 0.0), abs=1e-12)
    assert turned == pytest.approx((0.0, 0.01), abs=1e-12)


@pytest.mark.parametrize("fidelity", ["hertz", "sheet"])
def test_beside_the_object_nothing_touches(fidelity):
    assert World(scene(fidelity=fidelity)).contact(Pose((0.2, 0, 0.01)), 0.0).depth == 0.0


def test_the_sheet_takes_a_tilted_hand():
    """Tilted about its touch the hand still presses by the same depth, and the felt force is turned with it."""
    world = World(scene("rigid: true", "type: sphere, diameter: 20 mm, base: 30 mm", "sheet", "none"))
    flat = world.contact(Pose((0, 0, 0.045)), 0.03)
    tilted = world.contact(Pose((0, 0, 0.045), (0.1, 0, 0)), 0.03)
    assert flat.depth == pytest.approx(0.005)
    assert tilted.depth == pytest.approx(0.010 - 0.005 * math.cos(0.1))  # the ball's centre is 5 mm below the hand
    assert tilted.place.at == pytest.approx((0.0, 0.005 * math.sin(0.1)), abs=1e-9)
    assert math.hypot(*tilted.force) == pytest.approx(math.hypot(*flat.force), rel=0.02)
    across = tilted.force[1] / tilted.force[2]
    assert across == pytest.approx(-math.tan(0.1), rel=0.3)


@pytest.mark.parametrize("given", ["rigid: true", "stiffness: 0.9 N/mm"])
def test_while_the_hand_stands_what_remembers_its_path_alone_is_solved_once(given):
    world = coarse(scene(given, fidelity="sheet", effects="{mullins: on, sag: off}"))
    for time, height in ((0.0, TOP + 0.001), (0.5, TOP - 0.003), (0.6, TOP - 0.003), (0.7, TOP - 0.003)):
        world.advance(Pose((0, 0, height)), 0.02, time)
    known = world.contact(Pose((0, 0, TOP - 0.003)), 0.02, 0.75)
    before = world.stats.counts["contact"]
    assert all(world.contact(Pose((0, 0, TOP - 0.003)), 0.02, t) is known for t in (0.76, 0.8, 0.9))
    assert world.stats.counts["contact"] == before
    world.advance(Pose((0, 0, TOP - 0.004)), 0.02, 1.0)
    world.advance(Pose((0, 0, TOP - 0.003)), 0.02, 1.2)
    after = world.contact(Pose((0, 0, TOP - 0.003)), 0.02, 1.3)
    assert after.force[2] < known.force[2]


def test_what_changes_with_time_is_solved_at_each_moment():
    world = World(load_scene("pudding_balloon"))
    top, at = world.scene.object.top, world.scene.conditions.stretch
    for time, height in ((0.0, top + 0.001), (0.5, top - 0.006)):
        world.advance(Pose((0, 0, height)), at, time)
    forces = [world.contact(Pose((0, 0, top - 0.006)), at, t).force[2] for t in (0.6, 1.0, 2.0)]
    assert forces == sorted(forces, reverse=True)
    assert forces[0] > forces[2]


@pytest.mark.parametrize("fidelity", ["hertz", "sheet"])
def test_under_an_object_that_creeps_the_shape_keeps_up_with_it(fidelity):
    world = World(load_scene("pudding_balloon").model_copy(update={"fidelity": fidelity}))
    low, at = Pose((0, 0, world.scene.object.top - 0.006)), world.scene.conditions.stretch
    skins, depths = {}, []
    for time in np.arange(0.0, 1.0, 1 / 30):
        world.advance(low, at, time)
        contact = world.contact(low, at, time)
        skin = world.skin(contact, at)
        skins[id(skin)] = skin
        depths.append(contact.depth)
        solved = world.fidelity.press(contact.place, contact.depth, None).skin
        shown, true = (DepthRenderer(SR305, 0.2).render(seen) for seen in (skin, solved))
        assert np.abs(shown - true)[(shown > 0) & (true > 0)].max() < 2.5e-6
    assert np.ptp(depths) > 2e-5
    assert 2 < len(skins) < len(depths) / 2


def test_sag_touches_before_the_plane_does():
    hanging, flat = (coarse(scene("rigid: true", fidelity="sheet", effects=f"{{sag: {w}}}")) for w in ("on", "off"))
    lift = hanging.lift(Pose((0, 0, TOP)), 0.0)
    assert 2e-4 < lift < 1e-3
    above = Pose((0, 0, TOP + lift / 2))
    assert flat.contact(above, 0.0).force == (0.0, 0.0, 0.0)
    assert 0 < hanging.contact(above, 0.0).force[2] < 0.05
    assert hanging.contact(Pose((0, 0, TOP + 1.01 * lift)), 0.0).depth == 0.0
    deep = Pose((0, 0, TOP - 0.008))
    assert hanging.contact(deep, 0.0).force[2] > flat.contact(deep, 0.0).force[2]


@pytest.mark.parametrize("far", ["60 mm", "200 mm"])
def test_a_membrane_hangs_over_the_one_of_several_bodies_that_the_hand_would_meet(far):
    balls = "{type: sphere, diameter: 10 mm, rigid: true}, {type: sphere, diameter: 20 mm, rigid: true, position: {x: "
    world = coarse(scene("", f"type: several, objects: [{balls}{far}}}}}]", "sheet", "{sag: on}"))
    here = Pose((0, 0, 0.010))
    lift = world.lift(here, 0.0)
    assert world.contact(here.moved(z=0.9 * lift), 0.0).force[2] > 0 < lift
    assert world.contact(here.moved(z=1.01 * lift), 0.0).force[2] == 0.0


@dataclass(frozen=True)
class Dented(Response):
    """Stays down by half of the largest drop it has seen."""

    memory = math.inf

    def start(self):
        return 0.0

    def law(self, state, dt):
        return lambda drop: (900 * max(drop - state / 2, 0.0), 900.0)

    def rest(self, state, dt):
        return state / 2

    def after(self, state, drop, dt):
        return max(state, drop)


class DentedBall(SphereObject):
    def compliance(self):
        return Dented()


def test_what_has_a_memory_is_taken_from_moment_to_moment(soft):
    ball = soft.scene.object
    world = World(soft.scene.with_(object=DentedBall.model_construct(**dict(ball))))
    down, up = Pose((0, 0, TOP - 0.010)), Pose((0, 0, TOP + 0.010))
    first = world.contact(down, 0.0, 1.0)
    assert first.drop == pytest.approx(soft.contact(down, 0.0).drop)
    world.advance(up, 0.0, 0.0)
    world.advance(down, 0.0, 1.0)
    world.advance(up, 0.0, 2.0)
    again = world.contact(down, 0.0, 3.0)
    assert again.drop > first.drop
    assert again.force[2] < first.force[2]
    assert world.contact(down, 0.0, 0.5).drop == pytest.approx(first.drop)  # a moment ago nothing had been pressed
    assert world.contact(down, 0.0, 3.0) is again


def test_a_soft_object_drops_straight_down_under_a_tilted_hand():
    world = coarse(scene(fidelity="sheet", effects="none"))
    pose = Pose((0, 0, TOP - 0.006), (0.3, 0, 0))
    assert world.contact(pose, 0.03).drop == 0.0  # rigid, as nothing is on
    soft = coarse(scene(fidelity="sheet", effects="{sag: off, bending: off}"))
    found = soft.contact(pose, 0.03)
    assert found.drop == pytest.approx(found.force[2] / 900, rel=0.02)
    assert found.drop > 5e-4


def test_a_turned_object_off_centre_is_met_alike_by_a_hand_that_is_hardly_tilted():
    prism = scene(
        "rigid: true", "type: prism, length: 40 mm, width: 25 mm, height: 30 mm, heading: 30 deg", "sheet", "none"
    )
    world, at = coarse(prism), (0.006, -0.009, prism.object.top - 0.006)
    for yaw in (0.0, 0.7):
        flat = world.contact(Pose(at, (0, 0, yaw)), 0.02)
        tilted = world.contact(Pose(at, tuple(v + e for v, e in zip((0, 0, yaw), (2e-4, 1e-4, 0), strict=True))), 0.02)
        assert tilted.place.heading == pytest.approx(flat.place.heading, abs=1e-3)
        assert tilted.place.at == pytest.approx(flat.place.at, abs=2e-5)
        assert tilted.force == pytest.approx(flat.force, abs=0.02 * flat.force[2])


def test_a_lump_of_dough_rolls_where_the_hand_goes():
    """Pressed and moved across, it comes along by half of the way and loses its corners."""
    world = World(load_scene("dough_cube").with_(fidelity="hertz"))
    top = world.scene.object.top
    world.advance(Pose((0, 0, top + 0.01)), 0.06, 0.0)
    low = top - 0.004
    world.advance(Pose((0, 0, low)), 0.06, 1.0)
    for k in range(1, 41):
        world.advance(Pose((0.002 * k, 0, low)), 0.06, 1.0 + 0.1 * k)
    assert world.standing().x == pytest.approx(0.040, rel=0.2)
    assert world.truth(Pose((0.08, 0, low)), 0.06, 5.0)["roundness"] < 0.95 * 0.125


def test_a_moment_without_an_answer_is_told_once(soft):
    ball = soft.scene.object
    world = World(soft.scene.with_(object=DentedBall.model_construct(**dict(ball))))
    up, down = Pose((0, 0, TOP + 0.01)), Pose((0, 0, TOP - 0.010))
    world.advance(up, 0.0, 0.0)
    world.advance(down, 0.0, 1.0)
    with pytest.raises(NoEquilibrium, match="tilted"):
        world.advance(Pose((0, 0, TOP - 0.01), (0.1, 0, 0)), 0.0, 2.0)
    world.advance(up, 0.0, 3.0)
    assert world.latest == 3.0
    assert world.contact(down, 0.0, 4.0).drop > soft.contact(down, 0.0).drop


def test_friction_begins_anew_after_the_hand_has_lifted():
    rubbed = coarse(
        scene("rigid: true", "type: sphere, diameter: 20 mm, base: 30 mm", "sheet", "{friction: on, sag: off}")
    )
    top = rubbed.scene.object.top
    fresh = coarse(rubbed.scene)
    rubbed.advance(Pose((0, 0, top + 0.002)), 0.02, 0.0)
    rubbed.advance(Pose((0, 0, top - 0.004)), 0.02, 1.0)
    rubbed.advance(Pose((0, 0, top + 0.002)), 0.02, 2.0)
    aside = Pose((0.008, 0, top + 0.002))
    rubbed.advance(aside, 0.02, 3.0)
    fresh.advance(aside, 0.02, 3.0)
    press = Pose((0.008, 0, top - 0.003))
    assert rubbed.contact(press, 0.02, 4.0).force == pytest.approx(fresh.contact(press, 0.02, 4.0).force, rel=1e-3)


def test_the_true_force_of_a_hand_that_leans_is_along_its_axis():
    """It was the part along the world's z, which no node measures."""
    world = World(scene("rigid: true", fidelity="sheet", effects="none"))
    pose = Pose((0, 0, TOP - 0.008), (math.radians(15), 0.0, 0.0))
    force = np.array(world.contact(pose, 0.03, 0.0).force)
    along = float(force @ pose.matrix()[:, 2])
    assert world.truth(pose, 0.03)["force"] == pytest.approx(along, rel=1e-12)
    assert abs(along / force[2] - 1) > 0.01


@pytest.mark.parametrize("fidelity", ["hertz", "axisymmetric"])
def test_the_radius_of_a_top_that_flattens_is_the_one_that_presses(fidelity):
    """The truth said so, and the membrane was pressed by the radius that it had before."""
    made = load_scene("air_balloon").with_(fidelity=fidelity, effects="all")
    pose = Pose((0, 0, made.object.top - 0.0015))
    truth = World(made).truth(pose, 0.0)
    assert truth["radius"] > 1.05 * made.object.radius
    ball = scene("rigid: true", f"type: sphere, diameter: {2e3 * truth['radius']:.9f} mm", fidelity, "none")
    rigid = World(ball).truth(Pose((0, 0, ball.object.top - truth["depth"])), 0.0)
    assert truth["force"] == pytest.approx(rigid["force"], rel=1e-3)


def test_a_hand_that_was_conditioned_calls_for_softening():
    """Without it nothing of the press before the task was in the force."""
    hand = "hand: {conditioned: {diameter: 30 mm, stretch: 40 mm, depth: 10 mm}}\ntolerance: {force: 3 %}\n"
    for more, on in ((hand, True), ("tolerance: {force: 3 %}\n", False)):
        made = scene("rigid: true, base: 40 mm", "type: sphere, diameter: 30 mm", "sheet", "auto", more)
        assert {verdict.name: verdict.on for verdict in advise(made)}["mullins"] is on


def test_a_balloon_may_flatten_until_it_is_as_wide_as_the_round_membrane():
    """The ball that it stands below was wider than the membrane, which was a broken driver."""
    balloon = "type: balloon, diameter: 80 mm, pressure: 4 kPa, fill: {type: water}"
    world = World(
        parse_scene(f"format: stretch-scene/1\nobject: {{{balloon}}}\nfidelity: axisymmetric\neffects: all\n")
    )
    top = world.scene.object.top
    truth = world.truth(Pose((0, 0, top - 0.004)), 0.0)
    assert truth["force"] > 0.0
    assert truth["radius"] * 1.25 > 0.055
    with pytest.raises(NoEquilibrium, match="above the round membrane"):
        world.fidelity._solve(0.060, 0.0, 0.002)


@pytest.mark.parametrize("fidelity", ["hertz", "axisymmetric", "sheet"])
def test_the_lightest_touch_has_a_shape(fidelity):
    """An object that creeps is drawn in steps of 4 um, of which the first is 0."""
    world = World(scene("rigid: true", "type: sphere, diameter: 40 mm", fidelity, "none"))
    touch = world.contact(Pose((0, 0, 0.04 - 1e-6)), 0.0)
    skin = world.skin(replace(touch, depth=0.0), 0.0)
    depth = DepthRenderer(SR305, 0.2).render(skin, table_under(Pose((0, 0, 0.04))))
    assert depth[depth > 0].min() == pytest.approx(0.2, abs=1e-3)


def test_a_plane_under_a_tilted_hand_has_no_answer():
    world = World(scene("rigid: true, height: 40 mm", "type: plane", "hertz", "none"))
    with pytest.raises(NoEquilibrium, match="tilted"):
        world.contact(Pose((0, 0, 0.038), (0.1, 0, 0)), 0.0)


@pytest.mark.parametrize("stretch", [0.0, 0.03])
@pytest.mark.parametrize(
    "kind", ["type: box, length: 40 mm, width: 40 mm, height: 40 mm", "type: sphere, diameter: 30 mm"]
)
def test_past_the_side_of_the_sheet_nothing_touches(kind, stretch):
    """An object whose reach meets the membrane's border, and that stands beside it, was pressed without an equilibrium."""
    world = World(scene("rigid: true, base: 10 mm", kind, "sheet", "none"))
    top, free = world.scene.object.top, world.fidelity.free(stretch).points
    aside = 0.045 + world.scene.object.reach / (math.sqrt(2) if "box" in kind else 1)
    for x in np.linspace(aside + 1e-4, aside + 0.02, 5):
        contact = world.contact(Pose((float(x), 0, top - 0.010)), stretch)
        assert contact.force == (0.0, 0.0, 0.0)
        np.testing.assert_array_equal(world.skin(contact, stretch).points, free)
    assert world.contact(Pose((0.030, 0, top - 0.010)), stretch).force[2] > 0.1


def test_a_hand_is_conditioned_as_deep_as_it_says_although_it_hangs_lower():
    """From first contact: a slack membrane that hangs 7 mm was pressed by all of them where 2 mm were asked."""
    hand = "hand: {mount_prestretch: 0 mm, conditioned: {diameter: 30 mm, stretch: 0 mm, depth: 2 mm}}\n"
    made = scene("rigid: true, base: 40 mm", "type: sphere, diameter: 30 mm", "sheet", "{mullins: on, sag: on}", hand)
    pressed = []
    world = World(made)
    solve = world.fidelity.press
    world.fidelity.press = lambda place, depth, state: (
        pressed.append(depth + world.fidelity.lift(place)) or solve(place, depth, state)
    )
    world._conditioned()
    assert pressed == [pytest.approx(0.002)]
