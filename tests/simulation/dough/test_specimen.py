"""The dough in a run: what its effects change, and what the membrane meets."""

import numpy as np
import pytest

from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.dough.lump import STEP, Lump
from stretch_bt.simulation.dough.surface import upper_side
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.objects.dough import DoughObject
from stretch_bt.simulation.scene.file import load_scene
from stretch_bt.simulation.world import World

USUAL = ("plasticity", "springback")


def specimen(*names, **options):
    spec = DoughObject.model_validate({"type": "dough", **options})
    return spec.specimen(Active(registry()[name](registry()[name].Parameters()) for name in names))


def pushed(x=0.0, y=0.0, drop=0.0, force=1.0, dt=0.1):
    return Moved(drop, (0.0, 0.0, -force), (x, y), dt, 5e-3)


def rolled(thing, travel, seed=0, leg=0.02):
    state = thing.start(seed)
    for k in range(round(travel / leg)):
        state = thing.after(state, pushed(leg if k % 3 else 0.0, leg if k % 2 else -leg))
    return state


def test_the_scene_calls_for_what_it_is_about():
    on = {verdict.name for verdict in advise(load_scene("dough_cube")) if verdict.on}
    assert set(USUAL) <= on
    assert not on & {"compliance", "tack", "edge_cracks", "spin_noise", "dough_viscosity"}


def test_a_rigid_lump_rolls_as_it_is():
    thing = specimen()
    state = rolled(thing, 0.3)
    assert thing.law(state, 0.1) is None
    assert thing.known(state, 0.0)["roundness"] == pytest.approx(0.125, abs=0.002)
    assert thing.standing(state, 0.0).top > thing.spec.top
    assert thing.standing(state, 0.0).x > 0.02


def test_a_press_stays_and_comes_back_in_part():
    thing = specimen(*USUAL, yield_stress="1 kPa")
    state = thing.start()
    after = thing.after(state, pushed(drop=2e-3))
    top = thing.standing(after, 0.0).top
    assert thing.standing(state, 2e-3).top < top < thing.standing(state, 0.0).top
    same = thing.after(after, pushed(drop=thing.standing(after, 0.0).top - thing.standing(state, 2e-3).top))
    assert thing.standing(same, 0.0).top == pytest.approx(top, abs=5e-5)


def test_without_springback_all_of_a_press_stays():
    soft = {"yield_stress": "1 kPa"}
    kept = [specimen(*names, **soft) for names in (USUAL, ("plasticity",))]
    tops = [thing.standing(thing.after(thing.start(), pushed(drop=2e-3)), 0.0).top for thing in kept]
    assert tops[1] < tops[0]
    assert tops[1] == pytest.approx(0.023, abs=1.5e-4)


def test_only_a_dough_whose_force_depends_on_the_rate_changes_while_the_hand_stands():
    assert specimen(*USUAL).timeless
    assert not specimen(*USUAL, "dough_viscosity").timeless
    thing = specimen(*USUAL, "dough_viscosity")
    slow, fast = (thing.law(thing.start(), dt)(3e-3)[0] for dt in (100.0, 0.01))
    assert fast > 1.2 * slow


def test_tack_lessens_the_force_of_a_press():
    thing, bare = specimen(*USUAL, "tack"), specimen(*USUAL)
    with_, without = (t.law(t.start(), 0.1)(5e-4)[0] for t in (thing, bare))
    assert without - with_ == pytest.approx(0.1, rel=1e-3)
    assert thing.law(thing.start(), 0.1)(0.0)[0] == 0


def test_spin_and_cracks_are_of_the_seed():
    thing = specimen(*USUAL, "spin_noise", "edge_cracks", yield_stress="1 kPa")
    one, same, other = (
        thing.known(thing.after(rolled(thing, 0.2, seed), pushed(drop=5e-3)), 0.0) for seed in (1, 1, 2)
    )
    assert one == same
    assert one != other
    smooth = specimen(*USUAL, "spin_noise", yield_stress="1 kPa")
    plain = smooth.known(smooth.after(rolled(smooth, 0.2, 1), pushed(drop=5e-3)), 0.0)
    assert plain["roundness"] == one["roundness"]
    assert plain["circularity"] != one["circularity"]


def test_the_sheet_meets_a_ball_as_it_does_a_sphere():
    radius = 0.0155
    ball = Lump(np.full(500, radius), np.array([1.0, 0.0, 0.0, 0.0]), 4 / 3 * np.pi * radius**3)
    assert press(upper_side(ball), 0.06, 3e-3).force == pytest.approx(press("sphere:31mm", 0.06, 3e-3).force, rel=0.01)


def test_its_upper_side_is_as_high_as_it_is():
    lump = rolled(specimen(*USUAL), 0.6).lump
    assert upper_side(lump).heights.max() == pytest.approx(lump.extent[1], abs=5e-4)


def test_the_world_rolls_a_cube_round():
    from stretch_bt.frames import Pose

    world = World(load_scene("dough_cube").with_(fidelity="hertz"))
    start, time = world.truth(Pose((0.0, 0.0, 0.030)), 0.06)["roundness"], 0.0
    for k in range(60):
        time += 0.5
        x, y = 0.045 * np.sin(k / 4), 0.036 * np.sin(k / 4) * np.cos(k / 4)
        world.advance(Pose((float(x), float(y), 0.024)), 0.06, time)
    after = world.truth(Pose((0.0, 0.0, 0.045)), 0.06, time)
    assert after["roundness"] < 0.8 * start
    assert after["height"] > 0.026


def test_an_edge_cracks_by_the_press_since_the_lump_rolled_and_not_by_those_before():
    """Presses before it rolled counted for ever, so that a rolled lump had cracks."""
    rough = []
    for names in (("edge_cracks",), ()):
        thing = specimen(*USUAL, *names, yield_stress="1 kPa")
        state = thing.start()
        for _ in range(3):
            state = thing.after(state, pushed(drop=thing.standing(state, 0.0).top - 0.020))
        pressed = thing.known(state, 0.0)["edge_roughness"]
        state = thing.after(state, pushed(0.02, 0.0))
        assert state.lump.strain > 0
        rough.append((pressed, thing.known(state, 0.0)["edge_roughness"]))
    assert rough[0][0] > 1.3 * rough[1][0]
    assert rough[0][1] == pytest.approx(rough[1][1], rel=0.05)


@pytest.mark.parametrize("drop", [0.0, 5e-3])
def test_a_drag_shorter_than_a_step_of_rolling_changes_its_place_alone(drop):
    """Its cracks and its flat top stay until it has rolled a step."""
    thing = specimen(*USUAL, "edge_cracks", yield_stress="1 kPa")
    before = thing.after(thing.start(1), pushed(drop=drop))
    dragged = thing.after(before, pushed(1e-4, 0.0))
    assert (dragged.pressed, dragged.fresh) == (before.pressed, drop == 0.0)
    assert (before.pressed > 0.2) == (drop > 0)
    assert thing.known(dragged, 0.0) == thing.known(before, 0.0)
    was, is_ = thing.standing(before, 0.0), thing.standing(dragged, 0.0)
    assert type(is_.body) is type(was.body)
    assert (is_.top, is_.x) == (was.top, pytest.approx(was.x + 5e-5))
    on = dragged
    for _ in range(40):
        on = thing.after(on, pushed(1e-4, 0.0))
    assert (on.lump.steps, on.pressed, on.fresh) == (1, 0.0, False)


def test_what_an_effect_of_dough_needs_is_what_it_uses():
    known = registry()
    assert (known["edge_cracks"].needs, known["tack"].needs) == ("plasticity", None)


@pytest.mark.parametrize("drop", [0.0, 2e-3])
def test_its_thickness_is_how_high_it_stands_on_the_table(drop):
    """The thickness left out how far a lump sinks under its own weight: 0.3 mm of a soft cube of 60 mm."""
    thing = specimen(*USUAL, edge="60 mm", yield_stress="1 kPa")
    state = thing.start()
    assert thing.known(state, drop)["thickness"] == pytest.approx(thing.standing(state, drop).top - thing.spec.base)


@pytest.mark.parametrize("before", [0.1, 0.5, 0.9])  # of a step of rolling
def test_a_disc_stays_one_when_the_hand_stands_a_little_beside_where_it_was_sent(before):
    """The rest of a step from before the press was completed by the hand's jitter, and the disc was a lump that rolled."""
    thing = specimen(*USUAL, yield_stress="1 kPa")
    state = rolled(thing, 0.3)
    state = thing.after(state, pushed(before * 2 * STEP * state.lump.ball, 0.0))
    state = thing.after(state, pushed(drop=0.3 * state.lump.height))
    for k in range(12):
        state = thing.after(state, pushed(3e-5 * (-1) ** k, 3e-5))
    assert state.pressed > 0.25
