"""Dough that is pressed flat: its outline, its upper side, and the hand's frame; and what may go wrong on the way."""

import math

import numpy as np
import pytest

from stretch_bt.frames import Pose
from stretch_bt.perception import circularity
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.objects.dough import DoughObject
from stretch_bt.simulation.scene import load_scene
from stretch_bt.simulation.world import World
from stretch_bt.tree.declarations import OF_SCENE


def specimen(**options):
    spec = DoughObject.model_validate({"type": "dough", **options})
    return spec.specimen(
        Active(registry()[name](registry()[name].Parameters()) for name in ("plasticity", "springback"))
    )


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
    assert body.heights.max() == pytest.approx(state.lump.height / 2)


def test_the_frame_of_the_hand_presses_harder_than_the_membrane():
    scene = load_scene("dough_cube").with_(fidelity="hertz")
    framed, free = World(scene), World(scene.with_(hand=scene.hand.model_copy(update={"frame": None})))
    light, deep = Pose((0.0, 0.0, 0.020)), Pose((0.0, 0.0, 0.006))
    assert framed.truth(light, 0.06)["force"] == free.truth(light, 0.06)["force"]
    hard, soft = framed.truth(deep, 0.06), free.truth(deep, 0.06)
    assert hard["force"] > 1.2 * soft["force"]
    assert scene.hand.frame < hard["depth"] < scene.hand.frame + 1.5e-3
    assert hard["deflection"] > soft["deflection"]
