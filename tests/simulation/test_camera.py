import numpy as np
import pytest

from stretch_bt.frames import Intrinsics, Pose
from stretch_bt.simulation.camera import SR305, DepthRenderer, add_noise
from stretch_bt.simulation.scene import CameraNoise, load_scene
from stretch_bt.simulation.world import World

DISTANCE = 0.2
SMALL = Intrinsics(fx=238.0, fy=238.0, cx=160.0, cy=120.0, width=320, height=240)


def render(name="calibration_sphere", travel=0.01, stretch=0.02, x=0.0, y=0.0, intrinsics=SMALL):
    world = World(load_scene(name))
    pose = Pose((x, y, world.object.top - travel))
    contact = world.contact(pose, stretch)
    surface = world.surface(contact)
    depth = DepthRenderer(intrinsics, DISTANCE, 0.1, 0.09).render(surface, contact.axis, stretch, pose.height)
    return world, contact, surface, depth, pose


@pytest.mark.parametrize("name", ["calibration_sphere", "calibration_cylinder", "water_balloon"])
@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (0.007, -0.012), (-0.03, 0.04)])
def test_every_pixel_lies_on_the_surface(name, x, y):
    """Deprojected pixels of the membrane reproduce the profile that the solver gave, to a hundredth of a millimetre."""
    _, contact, surface, depth, _ = render(name, x=x, y=y)
    u, v = np.meshgrid(np.arange(SMALL.width), np.arange(SMALL.height))
    px = (u - SMALL.cx) / SMALL.fx * depth
    py = (v - SMALL.cy) / SMALL.fy * depth
    r = np.hypot(px - contact.axis[0], py - contact.axis[1])
    deformed = (depth > 0) & (depth < DISTANCE - 1e-5)
    assert deformed.sum() > 1000
    np.testing.assert_allclose(DISTANCE - depth[deformed], surface.height(r[deformed]), atol=1e-5)
    assert DISTANCE - depth[depth > 0].min() == pytest.approx(contact.depth, abs=2e-5)


def test_table_beside_the_sheet_and_nothing_at_its_ends():
    _, _, _, depth, pose = render(stretch=0.0, travel=-0.005)
    centre = depth[SMALL.height // 2]
    assert centre[SMALL.width // 2] == pytest.approx(DISTANCE)
    assert centre[5] == pytest.approx(DISTANCE + pose.height)
    assert np.all(depth[5] == 0)
    assert (centre == np.float32(DISTANCE)).sum() == pytest.approx(0.09 / DISTANCE * SMALL.fx, abs=1.5)


def test_a_plane_fills_the_sheet(tmp_path):
    path = tmp_path / "block.yaml"
    path.write_text("format: stretch-scene/1\nobject: {type: plane, height: 40 mm, rigid: true}\n")
    world = World(load_scene(path))
    contact = world.contact(Pose((0, 0, 0.037)), 0.0)
    depth = DepthRenderer(SMALL, DISTANCE, 0.1, 0.09).render(world.surface(contact), contact.axis, 0.0, 0.037)
    np.testing.assert_allclose(depth[100:140, 120:200], DISTANCE - 0.003, rtol=1e-6)


def noise(**changes):
    return CameraNoise.model_construct(**{"noise": 0.0, "quantisation": 0.000125, "dropout": 0.0, **changes})


def test_counts_are_quantised_and_invalid_stays_invalid():
    depth = np.array([[0.0, 0.2, 0.20006, 9.0]], np.float32)
    counts = add_noise(depth, noise(), np.random.default_rng(0))
    assert counts.dtype == np.uint16
    assert counts.tolist() == [[0, 1600, 1600, 0]]


def test_noise_and_dropout_are_as_asked():
    depth = np.full((400, 400), 0.2, np.float32)
    counts = add_noise(depth, noise(noise=0.0005, dropout=0.03), np.random.default_rng(4))
    assert (counts == 0).mean() == pytest.approx(0.03, rel=0.1)
    seen = counts[counts > 0] * 0.000125
    assert np.std(seen) == pytest.approx(np.hypot(0.0005, 0.000125 / 12**0.5), rel=0.02)
    assert np.mean(seen) == pytest.approx(0.2, abs=1e-5)


def test_one_seed_gives_one_image():
    depth = np.full((50, 50), 0.2, np.float32)
    first, again, other = (add_noise(depth, noise(noise=0.001), np.random.default_rng(s)) for s in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_the_full_image_has_the_sensors_size():
    assert render(intrinsics=SR305)[3].shape == (480, 640)
