"""Frames that show no membrane are refused for that; frames of a membrane are not."""

from dataclasses import replace

import numpy as np
import pytest
from no_membrane import LENS, UNIT, frame_of, rooms

from stretch_bt import open_cell
from stretch_bt.errors import IllConditioned
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.perception import find_contact, load_depth_png, mask_membrane
from stretch_bt.simulation.scene import load_scene

ROOMS = rooms()


def cut(frame, distance, size):
    placed = replace(frame, plane_distance=distance)
    return placed if size is None else mask_membrane(placed, gauge=size, width=0.9 * size, stretch=0.02)


@pytest.mark.parametrize(
    ("name", "distance", "size"),
    [
        ("tilted floor", 0.4, None),
        ("hand before a wall", 0.4, None),
        ("hand before a wall", 0.4, 0.1),
        ("ball before a wall", 0.4, 0.3),
        ("ball before nothing", 0.35, None),
        ("wall", 0.2, 0.1),
        ("steps", 0.3, None),
        ("corner", 0.5, 0.1),
        ("ball on a table", 0.3, None),
        ("ball on a table", 0.3, 0.1),
        ("block on a table", 0.3, None),
        ("block on a table", 0.3, 0.1),
        ("head before a wall", 0.8, None),
        ("cone on a table", 0.3, 0.1),
    ],
)
def test_a_room_is_no_membrane(name, distance, size):
    with pytest.raises(IllConditioned, match=r"no membrane.*look where the camera points"):
        find_contact(cut(frame_of(ROOMS[name]), distance, size))


@pytest.mark.parametrize("size", [None, 0.1, 0.3])
def test_a_person_is_no_membrane(data, size):
    for path in sorted((data / "sr305").glob("*.png"))[::3]:
        frame = load_depth_png(path, unit=UNIT, intrinsics=LENS)
        for distance in (0.5, 0.6, 0.7):
            with pytest.raises(IllConditioned, match="no membrane"):
                find_contact(cut(frame, distance, size))


def test_a_membrane_that_is_lifted_at_one_side_and_seen_by_a_wild_camera_stays_one(surfaces):
    depth = surfaces.render(surfaces.disc_press(8e-3, 20e-3), surfaces.camera(), x0=25e-3)
    rng = np.random.default_rng(0)
    seen = surfaces.noisy(depth, 0.3e-3, rng)
    seen[rng.random(seen.shape) < 0.02] += np.float32(0.1)  # pixels that fly
    raw = np.rint(seen / UNIT).astype(np.uint16)
    frame = DepthFrame(raw, UNIT, surfaces.camera(), 0.0, 0, surfaces.PLANE_DISTANCE)
    assert len(find_contact(frame).points) > 500


@pytest.mark.parametrize("behind", [3e-3, 6e-3, 10e-3, 0.1])
def test_a_table_beside_a_side_that_is_lifted_is_no_edge_of_an_object(surfaces, behind):
    """Deep presses of low objects were refused: the side stood 5 mm and more above the table."""
    depth = surfaces.render(surfaces.disc_press(14e-3, 20e-3), surfaces.camera())
    depth[:8, 100:233] = surfaces.PLANE_DISTANCE + behind
    seen = surfaces.noisy(depth, 0.3e-3, np.random.default_rng(0))
    frame = DepthFrame(np.rint(seen / UNIT).astype(np.uint16), UNIT, surfaces.camera(), 0.0, 0, surfaces.PLANE_DISTANCE)
    assert len(find_contact(frame).points) > 3000


@pytest.mark.parametrize(
    ("noise", "lost", "clump", "camera"),
    [(0.3e-3, 0.0, 8, ()), (0.3e-3, 0.0, 12, ()), (0.3e-3, 0.4, 12, ()), (2e-3, 0.0, 0, (430, 660, 950.0))],
)
def test_clumps_of_pixels_that_fly_and_heavy_noise_are_no_edges_of_objects(surfaces, noise, lost, clump, camera):
    camera = surfaces.camera(*camera)
    depth = surfaces.render(surfaces.disc_press(14e-3, 20e-3), camera)
    seen = surfaces.noisy(depth, noise, np.random.default_rng(1))
    for place in (40, 90, 140):
        seen[place : place + clump, 60 : 60 + clump] -= np.float32(0.01)
    seen[np.random.default_rng(10).random(seen.shape) < lost] = 0
    raw = np.rint(np.maximum(seen, 0) / UNIT).astype(np.uint16)
    frame = DepthFrame(raw, UNIT, camera, 0.0, 0, surfaces.PLANE_DISTANCE)
    assert len(find_contact(frame).points) > 2000


def test_a_table_past_the_sides_that_a_press_draws_in_is_none_of_the_membrane(surfaces):
    """A deep press was taken for a room."""
    depth = surfaces.render(surfaces.disc_press(14e-3, 20e-3), surfaces.camera())
    rows, columns = depth.shape
    middle = slice(rows // 3, 2 * rows // 3)
    for side in (slice(columns // 10), slice(-(columns // 10), None)):
        depth[middle, side] = surfaces.PLANE_DISTANCE + 0.022
    noisy = surfaces.noisy(depth, 0.3e-3, np.random.default_rng(0))
    raw = np.rint(noisy / UNIT).astype(np.uint16)
    frame = DepthFrame(raw, UNIT, surfaces.camera(), 0.0, 0, surfaces.PLANE_DISTANCE)
    assert len(find_contact(frame).points) > 500


def test_a_deep_press_of_the_twin_is_one_of_a_membrane():
    """`palpate_active` failed where it came to 17 mm, and boxes from 14 mm on were no membrane."""
    top = load_scene("paper_cube").object.top
    with open_cell("simulated", scene="paper_cube") as cell:
        cell.arm.move(Pose((0.0, 0.0, top - 0.018)), speed=0.1, owner="test")
        cell.do("wait", duration=2.0)
        frame = cell.do("average_frames", count=2).frame
        assert len(cell.do("segment_contact", frame=frame).contact.points) > 500
