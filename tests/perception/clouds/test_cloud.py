import struct
from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.accuracy.perception import objects
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import Pose
from stretch_bt.perception import cloud_of, draw_cloud, fuse_contact, measure_object

MM = 1e-3


def plane(x, y):
    return 0.03 + 0.3 * (x - objects.PLACE[0]) - 0.1 * (y - objects.PLACE[1])


def fused(noise, count, seed=0, **options):
    rng = np.random.default_rng(seed)
    cloud = None
    for _ in range(count):
        cloud = fuse_contact(objects.contact(objects.any_pose(rng), plane, noise, rng, **options), cloud)
    return cloud


@pytest.mark.parametrize("noise", [pytest.param(0.05 * MM, marks=pytest.mark.slow), 0.5 * MM])
def test_points_from_many_poses_fall_together_with_the_deviation_they_state(noise):
    cloud = fused(noise, 8)
    error = cloud.points[:, 2] - plane(*cloud.points[:, :2].T)
    for seen in (1, 8):
        these = cloud.seen == seen
        assert these.sum() > 300
        assert 0.65 < error[these].std() / np.sqrt(np.mean(cloud.noise[these] ** 2)) < 1.15
    assert abs(error.mean()) < 0.05 * noise
    assert np.mean(cloud.noise[cloud.seen == 8]) == pytest.approx(noise / np.sqrt(8), rel=0.05)
    assert 0.7 < cloud.disagreement < 1.1
    assert (cloud.sd >= cloud.floor).all()
    assert (cloud.contacts, cloud.frame) == (8, "world")
    assert np.abs(np.linalg.norm(cloud.rays, axis=1) - 1).max() < 1e-12


def test_a_contact_merges_with_points_from_elsewhere_in_its_columns():
    rng = np.random.default_rng(0)
    own = fused(0.05 * MM, 1)
    known = cloud_of(own.points, own.noise, rays=own.rays)
    found = fuse_contact(objects.contact(objects.any_pose(rng), plane, 0.05 * MM, rng), known)
    assert (found.seen == 2).sum() > 0.9 * len(known)
    assert np.abs(found.points[:, 2] - plane(*found.points[:, :2].T)).max() < 0.5 * MM
    assert len(cloud_of(np.array([[1e300, -1e300, 0.0]]), 1e-4)) == 1


def test_a_pose_that_is_wrong_shows_as_disagreement():
    rng = np.random.default_rng(0)
    seen = objects.contact(Pose((*objects.PLACE[:2], 0.04)), lambda x, y: 0.03 + 0 * x, 0.05 * MM, rng)
    moved = replace(seen, pose=seen.pose.moved(z=0.3 * MM))
    cloud = fuse_contact(moved, fuse_contact(seen))
    assert cloud.disagreement > 3
    assert np.median(cloud.sd) > 2 * np.median(cloud.noise)


def test_what_flies_is_dropped_and_what_is_elsewhere_once_is_outvoted():
    cloud = fused(0.1 * MM, 1, flying=0.01)
    clean = fused(0.1 * MM, 1)
    assert np.abs(cloud.points[:, 2] - plane(*cloud.points[:, :2].T)).max() < 1 * MM
    assert len(cloud) > 0.98 * len(clean)
    rng = np.random.default_rng(1)
    pose = Pose((*objects.PLACE[:2], 0.04))
    cloud = fuse_contact(objects.contact(pose, lambda x, y: plane(x, y) + 4 * MM, 0.1 * MM, rng))
    for count in (1, 2, 3):
        assert (np.abs(cloud.points[:, 2] - plane(*cloud.points[:, :2].T)) > 2 * MM).mean() > 0.4 if count > 1 else True
        cloud = fuse_contact(objects.contact(pose, plane, 0.1 * MM, rng), cloud)
    assert (np.abs(cloud.points[:, 2] - plane(*cloud.points[:, :2].T)) > 2 * MM).mean() < 0.02


def test_the_membrane_frame_is_turned_into_the_hand_and_the_world():
    rng = np.random.default_rng(0)
    seen = objects.contact(Pose((0.1, -0.2, 0.04), (0.1, -0.2, 0.7)), plane, 1e-6, rng)
    world = fuse_contact(seen)
    assert np.abs(world.points[:, 2] - plane(*world.points[:, :2].T)).max() < 5e-6
    hand = fuse_contact(replace(seen, pose=None, hand_height=0.5))
    assert hand.frame == "hand"
    assert hand.points[:, 2].mean() == pytest.approx(0.5 + seen.points[:, 2].mean(), abs=0.1 * MM)
    tilt = [np.polyfit(p[:, 1], p[:, 2], 1)[0] for p in (hand.points, seen.points)]
    assert tilt[0] == pytest.approx(-tilt[1], rel=0.02)
    with pytest.raises(InvalidInput, match="frame of the world"):
        fuse_contact(replace(seen, pose=None), world)
    with pytest.raises(InvalidInput, match="cell"):
        fuse_contact(seen, world, cell=1 * MM)


@pytest.mark.parametrize(("noise", "limit"), [(0.05 * MM, 0.02 * MM), (0.3 * MM, 0.06 * MM), (1.0 * MM, 0.25 * MM)])
def test_dimensions_are_the_distances_of_faces_however_the_edges_are_rounded(noise, limit):
    rng = np.random.default_rng(3)
    found = measure_object(objects.block((0.06, 0.02, 0.03), noise, rng, down=10 * MM, yaw=0.8))
    assert found.how == ("faces", "faces", "table")
    assert np.abs(found.lengths - [0.06, 0.02, 0.03]).max() < limit
    assert (np.abs(found.lengths - [0.06, 0.02, 0.03]) < 3 * found.sd).all()
    assert (found.sd < 0.2 * MM).all()
    assert np.abs(found.axes @ found.axes.T - np.eye(3)).max() < 0.05
    assert abs(found.axes[0] @ [np.cos(0.8), np.sin(0.8), 0.0]) > 0.999
    assert (found.length, found.width, found.height) == tuple(found.lengths)
    assert not found.short.any()


def test_the_deviation_of_a_dimension_is_that_of_its_spread():
    found = []
    for seed in range(7):
        rng = np.random.default_rng(seed)
        cloud = replace(objects.block((0.03, 0.02, 0.03), 0.3 * MM, rng), floor=0.0)
        found.append(measure_object(cloud))
    error = np.array([d.lengths - [0.03, 0.02, 0.03] for d in found])
    stated = np.sqrt(np.mean([d.sd**2 for d in found], axis=0))
    assert (np.sqrt(np.mean(error**2, axis=0)) < 2 * stated).all()
    assert (np.sqrt(np.mean(error**2, axis=0)) > 0.4 * stated).all()


def test_the_deviation_of_a_face_holds_when_near_points_err_alike():
    from scipy.ndimage import gaussian_filter

    x, y = np.meshgrid(np.arange(60) * 0.5 * MM, np.arange(40) * 0.5 * MM)
    heights, stated = [], []
    for seed in range(20):
        noise = gaussian_filter(np.random.default_rng(seed).normal(size=(80, 100)), 2.5)[20:-20, 20:-20]
        z = 0.03 + 0.5 * MM * noise * np.sqrt(4 * np.pi) * 2.5
        points = np.column_stack([v.ravel() for v in (x, y, z)])
        found = measure_object(cloud_of(points, 0.5 * MM, floor=0.0))
        assert found.how[2] == "table"
        heights.append(found.height)
        stated.append(found.sd[2])
    assert np.std(heights) > 0.03 * MM  # white noise of this size would give 0.01 mm
    assert 0.6 < np.mean(stated) / np.std(heights) < 1.6


def test_dimensions_without_opposite_faces_are_extents_that_say_so():
    rng = np.random.default_rng(0)
    three = measure_object(objects.block((0.04, 0.04, 0.04), 0.2 * MM, rng, flanks=(0, 1, 2)))
    assert sorted(three.how) == ["extent", "faces", "table"]
    k = three.how.index("extent")
    assert -2.5 * MM < three.lengths[k] - 0.04 < -0.5 * MM
    assert three.lengths[k] + three.short[k] == pytest.approx(0.04, abs=3 * three.sd[k])
    top = measure_object(objects.block((0.04, 0.04, 0.04), 0.2 * MM, rng, flanks=()))
    assert top.how == ("extent", "extent", "table")
    assert (top.lengths + top.short)[:2] == pytest.approx([0.04, 0.04], abs=1.5 * MM)
    assert top.height == pytest.approx(0.04, abs=0.03 * MM)


@pytest.mark.parametrize("noise", [pytest.param(0.05 * MM, marks=pytest.mark.slow), 0.3 * MM])
def test_a_round_side_is_no_face(noise):
    found = measure_object(objects.half_cylinder(0.02, 0.06, noise, np.random.default_rng(1)))
    assert found.how == ("faces", "extent", "extent")
    assert found.length == pytest.approx(0.06, abs=0.05 * MM)
    assert found.width == pytest.approx(0.04, abs=1 * MM)
    assert found.height == pytest.approx(0.02, abs=3 * found.sd[2])


@pytest.mark.parametrize(
    ("cloud", "how"),
    [
        (objects.block((0.04, 0.04, 0.04), 0.2 * MM, np.random.default_rng(0), flanks=()), "table"),
        (objects.half_cylinder(0.02, 0.06, 0.3 * MM, np.random.default_rng(1)), "extent"),
    ],
)
def test_an_error_that_all_heights_share_is_one_of_the_height_alone(cloud, how):
    # where the membrane lies on the object, and where it may stand off it
    apart = np.where(np.arange(len(cloud)) % 2, 0.2 * MM, 1 * MM)
    found, sharing = measure_object(cloud), measure_object(replace(cloud, apart=apart))
    assert found.how[2] == how
    more = np.sqrt(sharing.sd**2 - found.sd**2)
    assert more[2] == pytest.approx(0.2 * MM * (np.sqrt(2) if how == "extent" else 1))
    assert more[:2] == pytest.approx([0.0, 0.0])


def test_dimensions_do_not_depend_on_place_and_refuse_what_has_none():
    cloud = objects.block((0.03, 0.02, 0.03), 0.1 * MM, np.random.default_rng(0))
    far = replace(cloud, points=cloud.points + [1e3, -1e3, 0.0])
    assert measure_object(far).lengths == pytest.approx(measure_object(cloud).lengths, abs=1e-6)
    with pytest.raises(NoContact, match="no point"):
        measure_object(cloud_of(np.zeros((0, 3)), 1e-3))
    with pytest.raises(IllConditioned, match="at least 100"):
        measure_object(cloud_of(np.zeros((3, 3)), 1e-3))
    for points in (np.zeros((200, 3)), np.outer(np.arange(200.0), [1.0, 2.0, 3.0])):
        with pytest.raises(IllConditioned, match="line"):
            measure_object(cloud_of(points, 1e-3))
    with pytest.raises(InvalidInput, match=r"these are 33\.3 m wide"):
        measure_object(replace(cloud, points=cloud.points * 1e3, noise=cloud.noise * 1e3))


def read_ply(path):
    """Read the vertices of a PLY file by its header alone."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in header.decode().splitlines()]
    assert lines[0] == ["ply"]
    kind = next(line[1] for line in lines if line[0] == "format")
    count = next(int(line[2]) for line in lines if line[:2] == ["element", "vertex"])
    fields = [(line[2], line[1]) for line in lines if line[0] == "property"]
    if kind == "ascii":
        rows = [[float(v) for v in line.split()] for line in body.decode().splitlines()]
    else:
        layout = "<" + "".join({"double": "d", "float": "f", "uchar": "B", "int": "i"}[t] for _, t in fields)
        rows = [list(row) for row in struct.iter_unpack(layout, body)]
    assert len(rows) == count
    return {name: np.array([row[k] for row in rows]) for k, (name, _) in enumerate(fields)}


@pytest.mark.parametrize("text", [False, True])
def test_a_cloud_saved_as_ply_comes_back(tmp_path, text):
    cloud = fused(0.2 * MM, 2)
    cloud.save(tmp_path / "cloud.ply", text=text)
    found = read_ply(tmp_path / "cloud.ply")
    at = np.column_stack([found[k] for k in "xyz"])
    assert np.abs(at - cloud.points).max() < (1e-9 if text else 1e-15)
    assert found["sd"] == pytest.approx(cloud.sd, rel=1e-4)
    assert (found["seen"] == cloud.seen).all()
    surest, least = cloud.sd.argmin(), cloud.sd.argmax()
    assert found["blue"][surest] > found["red"][surest]
    assert found["red"][least] > found["blue"][least]


def test_a_cloud_is_drawn_from_three_sides(tmp_path):
    import cv2

    cloud = objects.block((0.04, 0.02, 0.03), 0.1 * MM, np.random.default_rng(0), yaw=0.0)
    cloud.save(tmp_path / "cloud.png")
    image = cv2.imread(str(tmp_path / "cloud.png"))
    assert image.shape == draw_cloud(cloud).shape
    panels = np.split(image[60:500], 3, axis=1)
    drawn = [np.argwhere((panel != 255).any(axis=2)) for panel in panels]
    sizes = [np.ptp(d, axis=0)[::-1] for d in drawn]
    assert sizes[0][0] / sizes[0][1] == pytest.approx(2.0, rel=0.05)
    assert sizes[1][0] == pytest.approx(sizes[0][0], abs=3)
    assert sizes[1][1] == sizes[2][1]
    draw_cloud(cloud_of(np.zeros((0, 3)), 1e-3))


def test_a_path_that_will_not_do_is_refused(tmp_path):
    cloud = fused(0.2 * MM, 1)
    (tmp_path / "taken.ply").write_bytes(b"mine")
    for name, text in (("taken.ply", "exists"), ("none/cloud.ply", "cannot be written"), ("cloud.obj", "cloud.ply")):
        with pytest.raises(InvalidInput, match=text):
            cloud.save(tmp_path / name)
    assert (tmp_path / "taken.ply").read_bytes() == b"mine"
