"""Dough that is pressed flat: its outline, its upper side, and the hand's frame; and what may go wrong on the way."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.errors import NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.perception import circularity
from stretch_bt.simulation.dough.disc import edge_roughness
from stretch_bt.simulation.dough.surface import disc_side
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.objects.dough import DoughObject
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World
from stretch_bt.tree.declarations import OF_SCENE

ANGLES = np.linspace(0, 2 * np.pi, 180, endpoint=False)


def specimen(**options):
    spec = DoughObject.model_validate({"type": "dough", **options})
    return spec.specimen(
        Active(registry()[name](registry()[name].Parameters()) for name in ("plasticity", "springback"))
    )


def oval(part, radius=0.018):
    reach = radius * (1 + part * np.cos(2 * ANGLES))
    return np.column_stack([reach * np.cos(ANGLES), reach * np.sin(ANGLES)])


@pytest.mark.parametrize("part", [0.0, 0.1])
def test_a_disc_is_flat_up_to_its_round_side(part):
    side = disc_side(oval(part), 0.014, 0.0155)
    middle = side.heights.shape[0] // 2
    assert side.heights[middle, middle] == pytest.approx(0.007)
    widest = np.argwhere(side.heights[middle] > 0)
    along = (widest.max() - widest.min()) * side.pitch / 2
    assert along == pytest.approx(0.018 * (1 + part), abs=1.5 * side.pitch)
    assert side.tip_radius == side.feature == 0.0155


def test_roughness_is_what_harmonics_leave():
    assert edge_roughness(oval(0.1)) == pytest.approx(0.0, abs=1e-3)
    rough = oval(0.0) * (1 + 0.02 * np.sqrt(2) * np.cos(20 * ANGLES))[:, None]
    assert edge_roughness(rough) == pytest.approx(0.02, rel=1e-6)


def test_the_outline_is_of_the_lump_that_rolled_last():
    thing = specimen(yield_stress="1 kPa")
    state = thing.start()
    for k in range(30):
        state = thing.after(state, Moved(0.0, (0.0, 0.0, -0.3), (0.02 * math.cos(k), 0.02 * math.sin(k)), 0.1, 5e-3))
    spread, steps = state.rolled.roundness, 0
    while state.pressed < 0.5:
        state = thing.after(state, Moved(2e-3, (0.0, 0.0, -3.0), (0.0, 0.0), 0.1, 5e-3))
        steps += 1
        assert steps < 100
    known = thing.known(state, 0.0)
    assert set(OF_SCENE) <= set(known)
    assert known["radius_spread"] == spread != known["roundness"]
    line = thing.outline(state, known["thickness"])
    assert known["circularity_true"] == pytest.approx(float(circularity(line)))
    assert known["pixel_chain_true"] < known["circularity_true"] <= known["low_pass_true"] + 0.01
    low = state.rolled
    assert np.pi * np.mean(np.sum(line**2, axis=1)) * known["thickness"] == pytest.approx(low.volume, rel=1e-2)
    body = thing.standing(state, 0.0).body
    assert body.heights.max() == pytest.approx(known["thickness"] / 2)


def test_the_frame_of_the_hand_presses_harder_than_the_membrane():
    scene = load_scene("dough_cube").with_(fidelity="hertz")
    framed, free = World(scene), World(scene.with_(hand=scene.hand.model_copy(update={"frame": None})))
    light, deep = Pose((0.0, 0.0, 0.020)), Pose((0.0, 0.0, 0.006))
    assert framed.truth(light, 0.06)["force"] == free.truth(light, 0.06)["force"]
    hard, soft = framed.truth(deep, 0.06), free.truth(deep, 0.06)
    assert hard["force"] > 1.2 * soft["force"]
    assert scene.hand.frame < hard["depth"] < scene.hand.frame + 1.5e-3
    assert hard["deflection"] > soft["deflection"]


def moved(world, points, height, stretch=0.06, step=0.5):
    """Lead the hand through points at a height, m; return the truth with the hand away."""
    time = 0.0
    for x, y in points:
        time += step
        world.advance(Pose((x, y, height)), stretch, time)
    return world.truth(Pose((0.0, 0.0, 0.09)), stretch, time)


ROUND = [(0.045 * math.sin(k / 4), 0.036 * math.sin(k / 4) * math.cos(k / 4)) for k in range(50)]
HARD = {
    "never touched": {"height": 0.040},
    "it wanders off the membrane": {"points": [(0.06 * k, 0.0) for k in range(6)]},
    "steps ten times as long": {"step": 5.0},
    "100 directions": {"directions": 100},
    "8000 directions": {"directions": 8000, "points": ROUND[:8]},
    "yields at nothing": {"yield": 0.4},
    "never yields": {"yield": 1e5},
    "past its bulk yield": {"height": 0.014},
}


@pytest.mark.parametrize("name", HARD)
def test_hard_cases_have_an_answer(name):
    case = {"points": ROUND, "height": 0.024, "step": 0.5, "directions": 500, "yield": 5.0, **HARD[name]}
    scene = load_scene("dough_cube").with_(fidelity="hertz")
    spec = DoughObject.model_validate(
        {
            "type": "dough",
            "directions": case["directions"],
            "yield_stress": f"{case['yield']} kPa",
            "modulus": f"{20 * case['yield']} kPa",
        }
    )
    world = World(scene.with_(object=spec))
    try:
        after = moved(world, case["points"], case["height"], step=case["step"])
    except NoEquilibrium as refusal:
        assert name in ("past its bulk yield", "yields at nothing"), refusal
        assert "flat" in str(refusal) or "ragged" in str(refusal)
        return
    assert all(math.isfinite(value) for value in after.values())
    lump = world._past[-1].thing.lump
    drift = np.sum(lump.radii**3) * lump.directions.solid_angle / 3 / lump.volume - 1
    assert abs(drift) < 1e-12
    if name in ("never yields", "never touched"):
        assert after["radius_spread"] == pytest.approx(0.125, abs=0.003)
    if name == "it wanders off the membrane":
        half, reach = world.membrane.width / 2, spec.reach
        assert 0.02 < lump.x < half + reach, "it stays behind, and is not rolled on by a hand that is past it"
    if name == "steps ten times as long":
        assert after == pytest.approx(moved(World(scene.with_(object=spec)), case["points"], case["height"]))


def test_a_lump_that_the_hand_loses_on_the_way_stays_as_it_was():
    world, time, lumps = World(load_scene("dough_cube").with_(fidelity="hertz")), 0.0, []
    for height in (0.024, 0.040, 0.024):
        for x, y in ROUND[:12]:
            time += 0.5
            world.advance(Pose((x, y, height)), 0.06, time)
        lumps.append(world._past[-1].thing.lump)
    assert lumps[0].steps > 0
    assert lumps[1] is lumps[0], "the hand goes on without it"
    assert lumps[2].steps > lumps[0].steps, "and finds it again"


def test_a_cube_under_the_table_is_refused():
    text = "format: stretch-scene/1\nobject: {type: dough, base: -5 mm}\ntolerance: {height: 1 mm}\n"
    with pytest.raises(SceneError) as refusal:
        parse_scene(text)
    assert "base" in str(refusal.value)


def test_a_path_cut_elsewhere_is_the_same():
    scene = load_scene("dough_cube").with_(fidelity="hertz")
    once, twice = World(scene), World(scene)
    for world, parts in ((once, 1), (twice, 4)):
        time, at = 0.0, (0.0, 0.0)
        for x, y in ROUND[:20]:
            for k in range(1, parts + 1):
                time += 0.5 / parts
                part = k / parts
                world.advance(Pose((at[0] + part * (x - at[0]), at[1] + part * (y - at[1]), 0.024)), 0.06, time)
            at = (x, y)
    spreads = [w.truth(Pose((0.0, 0.0, 0.09)), 0.06, 10.0)["radius_spread"] for w in (once, twice)]
    assert spreads[0] == pytest.approx(spreads[1], abs=0.01)
    assert replace(once._past[-1], time=0.0).thing.rolled.steps == twice._past[-1].thing.rolled.steps
