"""Objects that stand side by side, further apart than the membrane reaches: each is met as if it stood alone."""

import math

import numpy as np
import pytest

from stretch_bt.frames import Pose
from stretch_bt.simulation.scene import parse_scene
from stretch_bt.simulation.world import World

SPHERES = (30.0, 33.0, 29.0)
PLACES = ((-250.0, 0.0), (250.0, 40.0), (60.0, -200.0))


def sphere(diameter, rest=""):
    return f"{{type: sphere, diameter: {diameter} mm, rigid: true{rest}}}"


def world(text):
    return World(parse_scene(f"format: stretch-scene/1\neffects: {{sag: on}}\nobject: {text}\n"))


@pytest.fixture(scope="module")
def row():
    each = [sphere(d, f", position: {{x: {x} mm, y: {y} mm}}") for d, (x, y) in zip(SPHERES, PLACES, strict=True)]
    return world(f"{{type: several, heading: 30 deg, position: {{x: 10 mm, y: -5 mm}}, objects: [{', '.join(each)}]}}")


def hand_over(place, above):
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    x, y = (1e-3 * v for v in place)
    return Pose((0.010 + c * x - s * y, -0.005 + s * x + c * y, above))


@pytest.mark.parametrize("k", range(3))
def test_each_is_met_as_if_it_stood_alone(row, k):
    alone = world(sphere(SPHERES[k]))
    for depth in (-1e-3, 1e-3, 8e-3):
        pose = hand_over(PLACES[k], 1e-3 * SPHERES[k] - depth)
        truth, told = row.truth(pose, 0.02), alone.truth(Pose((0.0, 0.0, pose.height)), 0.02)
        assert {name: truth[name] for name in ("force", "depth", "height", "contact_height")} == pytest.approx(
            {name: told[name] for name in ("force", "depth", "height", "contact_height")}, rel=1e-9, abs=1e-12
        )
        assert row.buried(pose, 0.02) == pytest.approx(max(depth, 0.0), abs=1e-12)


def test_between_them_the_membrane_goes_down_to_the_table(row):
    between = hand_over((0.0, 0.0), 2e-3)
    assert row.contact(between, 0.02).force == (0.0, 0.0, 0.0)
    free = row.skin(row.contact(between, 0.02), 0.02).points
    assert np.array_equal(free, row.fidelity.free(0.02).points)
    assert row.buried(between, 0.02) == 0.0


def test_two_under_one_membrane_are_met_together():
    pair = world(
        f"{{type: several, objects: [{sphere(30, ', position: {x: -20 mm}')}, {sphere(32, ', position: {x: 20 mm}')}]}}"
    )
    high, both = (pair.contact(Pose((0.0, 0.0, height)), 0.02) for height in (0.031, 0.022))
    assert (high.depth, both.depth) == (pytest.approx(0.001), pytest.approx(0.010))
    assert both.force[2] > 5 * high.force[2] > 0


@pytest.mark.parametrize(("x", "height"), [(0.0, 12.0), (0.0, 9.0), (-19.0, 12.0)])
def test_a_snowman_that_hardly_gives_way_is_met_as_a_rigid_one(x, height):
    """By the same domes at the same places: the hand is over the middle of three, or over the largest."""
    rigid, hard, soft = (
        World(
            parse_scene(
                "format: stretch-scene/1\neffects: {compliance: on}\n"
                f"object: {{type: snowman, diameters: [28 mm, 22 mm, 16 mm], {law}}}\n"
            )
        ).contact(Pose((1e-3 * x, 0.0, 1e-3 * height)), 0.02)
        for law in ("rigid: true", "stiffness: 10000 N/mm", "stiffness: 0.9 N/mm")
    )
    assert hard.force == pytest.approx(rigid.force, rel=1e-4, abs=1e-9)
    assert hard.place == soft.place == rigid.place
    assert rigid.force[2] > soft.force[2] == pytest.approx(900 * soft.drop)
