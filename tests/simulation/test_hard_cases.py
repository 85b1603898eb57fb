"""Scenes that nobody wants to meet: each ends with an answer that can be true, or with the reason why there is none."""

import math

import numpy as np
import pytest

from stretch_bt.errors import NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.simulation.scene import parse_scene
from stretch_bt.simulation.world import World

HEAD = "format: stretch-scene/1\n"
BALL = "object: {type: sphere, diameter: 20 mm, rigid: true, base: 20 mm}\n"


def ball(law):
    return f"object: {{type: sphere, diameter: 40 mm, {law}}}\n"


def balloon(pressure):
    return f"object: {{type: balloon, diameter: 60 mm, base: 30 mm, pressure: {pressure}, fill: {{type: water}}}}\n"


TWO = """\
object:
  type: several
  objects:
    - {type: sphere, diameter: 10 mm, rigid: true, position: {x: -10 mm}}
    - {type: sphere, diameter: 10 mm, rigid: true, position: {x: 10 mm}}
"""

# what is in the scene, where the hand is (x, z), the stretch, and what comes of it: a range of force, N, or the reason
CASES = {
    "a ball smaller than a few pixels": (
        "object: {type: sphere, diameter: 5 mm, rigid: true, base: 20 mm}\n",
        (0.0, 0.023),
        0.0,
        (0.01, 0.3),
    ),
    "wider than the membrane": (
        "object: {type: box, length: 200 mm, width: 200 mm, height: 40 mm, rigid: true}\n",
        (0.0, 0.038),
        0.0,
        "clamp",
    ),
    "wider than the membrane, in closed form": (
        "object: {type: plane, height: 40 mm, rigid: true}\nfidelity: hertz\n",
        (0.0, 0.038),
        0.0,
        (0.1, 10.0),
    ),
    "at the free edge": (BALL, (0.044, 0.035), 0.03, (0.05, 2.0)),
    "at the clamp": (BALL + "hand: {mount_prestretch: 0 mm}\n", (0.0, 0.035, 0.049), 0.0, "clamp"),
    "beside the membrane": (BALL, (0.2, 0.03), 0.0, (0.0, 0.0)),
    "the hand deeper than the object is high": (BALL, (0.0, 0.002), 0.0, (2.0, 30.0)),
    "an object that gives way all the way down": (ball("stiffness: 0.005 N/mm"), (0.0, 0.001), 0.08, (0.1, 0.2)),
    "hanging at stretch 0 without pre-stretch": (
        BALL + "hand: {mount_prestretch: 0 mm}\neffects: {sag: on}\n",
        (0.0, 0.036),
        0.0,
        (1e-3, 0.3),
    ),
    "as good as infinitely stiff": (ball("stiffness: 10000 N/mm"), (0.0, 0.032), 0.0, (0.2, 2.0)),
    "as good as without stiffness": (ball("stiffness: 0.001 N/mm"), (0.0, 0.032), 0.0, (1e-6, 0.02)),
    "a balloon without pressure": (balloon("0 kPa"), (0.0, 0.055), 0.0, (0.0, 0.0)),
    "a balloon blown up hard": (balloon("10 kPa"), (0.0, 0.055), 0.0, (0.1, 1.0)),
    "two objects": (TWO, (0.0, 0.006), 0.0, (0.05, 1.0)),
}


@pytest.mark.parametrize("name", CASES)
def test_each_scene_ends_with_an_answer_or_a_reason(name):
    text, (x, z, *y), stretch, expected = CASES[name]
    world = World(parse_scene(HEAD + text))
    pose = Pose((x, y[0] if y else 0.0, z))
    if not isinstance(expected, str):
        truth = world.truth(pose, stretch)
        assert expected[0] <= truth["force"] <= expected[1]
        assert all(math.isfinite(value) for value in truth.values())
        return
    with pytest.raises(NoEquilibrium, match=expected):
        world.contact(pose, stretch)


# effects, and the part of the pixels of the membrane that has a value
NOISES = {
    "{white_noise: {sd: 0 mm}}": (0.9, 1.0),
    "{white_noise: {sd: 50 mm}}": (0.9, 1.0),
    "{correlated_noise: {sd: 50 mm}}": (0.9, 1.0),
    "{fixed_pattern: {sd: 0 mm}}": (0.9, 1.0),
    "{dropout: {share: 1.0}}": (0.0, 0.0),
}


@pytest.mark.parametrize("effects", NOISES)
def test_noise_of_any_size_gives_frames(effects):
    cell = open_cell(load_cell("simulated"), now=lambda: 1.0, scene=parse_scene(f"{HEAD}{BALL}effects: {effects}\n"))
    frame = cell.devices["camera"].frame(1.0).value
    middle = frame.depth[100:-100, 60:-60]
    assert NOISES[effects][0] <= np.mean(middle > 0) <= NOISES[effects][1]


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        (BALL + "effects:\n  sag: off\n  plasticity: on\n", 5, "a sphere has no plasticity"),
        (BALL + "effects:\n  viscosity: {relaxation: 2 s}\n", 4, "viscosity"),
        ("fidelity: sheet\n", 1, "object is missing"),
    ],
)
def test_what_a_scene_cannot_have_is_told_with_its_line(text, line, said):
    with pytest.raises(SceneError) as refused:
        parse_scene(HEAD + text)
    assert [d.line for d in refused.value.diagnostics] == [line]
    assert said in refused.value.diagnostics[0].message
