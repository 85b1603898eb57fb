import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from stretch_bt.accuracy.perception.noise import Noise, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardcases.strategies.perception import IMAGES, RULES
from stretch_bt.perception import (
    classify,
    deproject,
    find_contact,
    fit_sphere,
    load_depth_png,
    segment,
    to_membrane,
    track_height,
    view_rays,
)
from stretch_bt.perception.height import MOST
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, UNDEFORMED
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere as Ball
from stretch_bt.units import Estimate

NOISE = 0.3e-3


def overlap(found, truth):
    return (found & truth).sum() / (found | truth).sum()


def as_seen(surfaces, depth, frame, noise=NOISE, seed=0):
    seen = surfaces.noisy(depth, noise, np.random.default_rng(seed)) if noise else depth
    points, valid = deproject(seen, surfaces.camera(*depth.shape))
    return (to_membrane(points, surfaces.PLANE_DISTANCE) if frame == "membrane" else points), valid


@pytest.mark.parametrize("frame", ["camera", "membrane"])
@pytest.mark.parametrize(("radius", "angle", "least"), [(10e-3, 45, 0.8), (15e-3, 30, 0.85), (30e-3, 25, 0.9)])
def test_a_spherical_cap_is_found_without_its_skirt_and_carries_its_radius(surfaces, frame, radius, angle, least):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(radius, np.radians(angle)), lens)
    truth = surfaces.distance_from_axis(depth, lens) < radius * np.sin(np.radians(angle))
    ratios = []
    for seed in range(5):
        points, valid = as_seen(surfaces, depth, frame, seed=seed)
        touching = segment(points, valid) == CONTACT
        assert overlap(touching, truth & valid) > least
        at = surfaces.PLANE_DISTANCE if frame == "membrane" else 0.0
        ratios.append(fit_sphere(points[touching], rays=view_rays(points[touching], (0.0, 0.0, at))).radius / radius)
    assert np.median(ratios) == pytest.approx(1.0, abs=0.05 if angle >= 30 else 0.06)


def test_a_10_mm_press_of_a_30_mm_sphere_gives_its_radius(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(30e-3, np.radians(24.2)), lens)
    assert surfaces.PLANE_DISTANCE - depth.min() == pytest.approx(10e-3, abs=0.2e-3)
    ratios = []
    for seed in range(10):
        raw = np.round(surfaces.noisy(depth, 0.2e-3, np.random.default_rng(seed)) / 0.125e-3).astype(np.uint16)
        contact = find_contact(DepthFrame(raw, 0.125e-3, lens, 1.5, 0, surfaces.PLANE_DISTANCE, 0.3, 0.01))
        ratios.append(fit_sphere(contact.points, rays=contact.rays).radius / 30e-3)
    assert np.median(ratios) == pytest.approx(1.0, abs=0.03)
    assert (contact.hand_height, contact.stretch, contact.time) == (0.3, 0.01, 1.5)
    assert contact.noise == pytest.approx(0.2e-3, rel=0.15)
    assert contact.points.shape == contact.rays.shape
    assert 5e-3 < contact.points[:, 2].mean() < 10.2e-3
    assert (contact.rays[:, 2] < -0.9).all()


@pytest.mark.parametrize("frame", ["camera", "membrane"])
@pytest.mark.parametrize(
    ("diameter", "depth", "least"), [(10e-3, 10e-3, 0.8), (20e-3, 5e-3, 0.88), (30e-3, 10e-3, 0.93)]
)
def test_a_flat_face_is_a_full_disc(surfaces, frame, diameter, depth, least):
    lens = surfaces.camera()
    image = surfaces.render(surfaces.disc_press(diameter / 2, depth), lens)
    r = surfaces.distance_from_axis(image, lens)
    points, valid = as_seen(surfaces, image, frame)
    labels = segment(points, valid)
    assert overlap(labels == CONTACT, (r < diameter / 2) & valid) > least
    assert (labels[valid & (r < 0.4 * diameter)] == CONTACT).all()


@pytest.mark.parametrize("focal", [240.0, 480.0, pytest.param(960.0, marks=pytest.mark.slow)])
def test_classes_do_not_depend_on_the_pixel_pitch(surfaces, focal):
    lens = surfaces.camera(int(213 * focal / 480), int(333 * focal / 480), focal)
    depth = surfaces.render(surfaces.sphere_press(20e-3, np.radians(35)), lens)
    truth = surfaces.distance_from_axis(depth, lens) < 20e-3 * np.sin(np.radians(35))
    seen = surfaces.noisy(depth, NOISE, np.random.default_rng(0))
    points, valid = deproject(seen, lens)
    assert overlap(segment(points, valid) == CONTACT, truth & valid) > 0.85


def test_the_rule_of_the_paper_takes_in_more_of_the_skirt(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(15e-3, np.radians(30)), lens)
    points, valid = as_seen(surfaces, depth, "membrane")
    either = segment(points, valid, rule="either") == CONTACT
    mean = segment(points, valid) == CONTACT
    assert (mean & ~either).sum() < 0.1 * mean.sum()
    assert either.sum() > 1.3 * mean.sum()


def test_the_three_classes_cover_the_frame(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.disc_press(10e-3, 10e-3), lens)
    r = surfaces.distance_from_axis(depth, lens)
    points, valid = as_seen(surfaces, depth, "membrane")
    labels = segment(points, valid)
    assert labels.dtype == np.uint8
    assert set(np.unique(labels)) == {UNDEFORMED, DEFORMED, CONTACT, INVALID}
    assert (labels[~valid] == INVALID).all()
    assert (labels[valid & (r > 14e-3) & (r < 35e-3)] == DEFORMED).mean() > 0.99
    assert (labels[valid & (r > 50e-3)] == UNDEFORMED).mean() > 0.99


@pytest.mark.parametrize("frame", ["camera", "membrane"])
@pytest.mark.parametrize("noise", [0.0, 0.2e-3, 1e-3])
def test_a_flat_membrane_has_no_contact(surfaces, frame, noise):
    plane = np.full((213, 333), surfaces.PLANE_DISTANCE)
    for seed in range(3):
        labels = segment(*as_seen(surfaces, plane, frame, noise, seed))
        assert not (labels == CONTACT).any()
        assert (labels == DEFORMED).mean() < 0.01


@settings(max_examples=40)
@given(depth=IMAGES, rule=RULES)
def test_any_frame_is_sorted_into_the_four_labels(surfaces, depth, rule):
    points, valid = deproject(depth, surfaces.camera(*depth.shape))
    labels = segment(points, valid, rule=rule)
    assert labels.shape == valid.shape
    assert np.isin(labels, [UNDEFORMED, DEFORMED, CONTACT, INVALID]).all()
    assert (labels[~valid] == INVALID).all()


def test_a_contact_cut_by_the_edge_of_the_frame_keeps_its_radius(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.sphere_press(30e-3, np.radians(25)), lens, x0=64e-3)
    points, valid = as_seen(surfaces, depth, "membrane")
    touching = points[segment(points, valid) == CONTACT]
    assert fit_sphere(touching).radius == pytest.approx(30e-3, rel=0.1)


def test_scenes_without_a_membrane_do_not_break_it(data):
    lens = Intrinsics(476.007, 476.007, 313.683, 242.755, 640, 480)
    for path in sorted((data / "sr305").glob("*.png"))[::4]:
        frame = load_depth_png(path, unit=0.125e-3, intrinsics=lens)
        points, valid = deproject(frame)
        try:
            labels = segment(points, valid)
        except IllConditioned as refused:
            assert "sees no membrane" in refused.reason
            continue
        assert (labels[~valid] == INVALID).all()
        assert (labels[valid] == INVALID).mean() < 0.2


def test_a_frame_without_contact_or_plane_is_refused(surfaces):
    lens = surfaces.camera(60, 80)
    raw = np.full((60, 80), 1600, dtype=np.uint16)
    with pytest.raises(NoContact, match="curved and raised"):
        find_contact(DepthFrame(raw, 0.125e-3, lens, 0.0, 0, 0.2))
    with pytest.raises(NoContact, match="no pixel of the frame has depth"):
        find_contact(DepthFrame(0 * raw, 0.125e-3, lens, 0.0, 0, 0.2))
    with pytest.raises(InvalidInput, match="plane_distance"):
        find_contact(DepthFrame(raw, 0.125e-3, lens, 0.0, 0))
    with pytest.raises(InvalidInput, match="rule"):
        segment(np.zeros((5, 5, 3)), np.ones((5, 5), dtype=bool), rule="both")


@pytest.mark.parametrize(("shape", "top"), [("disc", 10e-3), ("sphere", None)])
def test_height_of_the_top_is_right_within_its_deviation(surfaces, shape, top):
    lens = surfaces.camera()
    profile = surfaces.disc_press(8e-3, 10e-3) if shape == "disc" else surfaces.sphere_press(15e-3, np.radians(35))
    depth = surfaces.render(profile, lens)
    truth = top or surfaces.PLANE_DISTANCE - depth.min()
    errors, stated = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        seen = surfaces.noisy(depth, NOISE, rng)
        seen[rng.random(seen.shape) < 0.003] -= np.float32(15e-3)
        points, valid = deproject(seen, lens)
        points = to_membrane(points, surfaces.PLANE_DISTANCE)
        height = track_height(points, valid, segment(points, valid))
        errors.append(height.value - truth)
        stated.append(height.sd)
    assert abs(np.mean(errors)) < 0.03e-3
    assert 0.5 < np.mean(stated) / np.std(errors) < 2.0


def test_a_known_curvature_halves_the_error_of_a_height_and_is_left_aside_where_it_is_wrong(surfaces):
    lens, radius = surfaces.camera(), 30e-3
    depth = surfaces.render(surfaces.sphere_press(radius, np.radians(12)), lens)
    truth = surfaces.PLANE_DISTANCE - depth.min()
    known = {"free": None, "known": Estimate(1 / radius, 0.3), "wrong": Estimate(5 / radius, 0.3)}
    errors = {name: [] for name in known}
    for seed in range(16):
        points, valid = deproject(surfaces.noisy(depth, NOISE, np.random.default_rng(seed)), lens)
        points = to_membrane(points, surfaces.PLANE_DISTANCE)
        for name, curvature in known.items():
            height = track_height(points, valid, segment(points, valid), curvature=curvature)
            errors[name].append(height.value - truth)
    spread = {name: np.std(e) for name, e in errors.items()}
    assert spread["known"] < 0.7 * spread["free"]
    assert errors["wrong"] == errors["free"]
    with pytest.raises(InvalidInput, match="curvature"):
        track_height(points, valid, segment(points, valid), curvature=Estimate(np.nan, 1.0))


@pytest.mark.parametrize(
    "noise", [0.0, pytest.param(0.15, marks=pytest.mark.slow), pytest.param(0.3, marks=pytest.mark.slow), 0.6]
)
def test_steps_of_depth_enter_the_deviation_of_a_flat_top_as_far_as_noise_leaves_them(surfaces, noise):
    step, rng, lens, parts = 0.125e-3, np.random.default_rng(3), surfaces.camera(), []
    for part in rng.random(40):
        depth = surfaces.render(surfaces.disc_press(12e-3, 4e-3 + part * step), lens)
        points, valid = deproject(surfaces.noisy(depth, noise * step, rng, quantum=step), lens)
        points = to_membrane(points, surfaces.PLANE_DISTANCE)
        height = track_height(points, valid, segment(points, valid))
        parts.append((height.value - surfaces.PLANE_DISTANCE + depth.min()) / height.sd)
    assert 0.4 < np.sqrt(np.mean(np.square(parts))) < 1.3


def test_the_height_of_very_many_points_is_that_of_some_and_says_so():
    rng, noise = np.random.default_rng(5), 1e-4
    y, x = np.mgrid[:400, :400] * 4e-4
    points = np.dstack([x, y, 5e-3 + rng.normal(0, noise, x.shape)])
    height = track_height(points, np.ones(x.shape, dtype=bool), np.full(x.shape, CONTACT, dtype=np.uint8))
    within = 0.75**2 / 2  # of the points lie in the disc that is fitted, roughly
    assert 0.5 < height.sd / (noise / np.sqrt(MOST * within)) < 2.0
    assert abs(height.value - 5e-3) < 4 * height.sd


def seen_from(distance, profile, lens):
    """Depth of a profile about the axis of a camera that far above the flat membrane, by bisection."""
    x = ((np.arange(lens.width) - lens.cx) / lens.fx)[None, :]
    y = ((np.arange(lens.height) - lens.cy) / lens.fy)[:, None]
    low, high = (np.full((lens.height, lens.width), d) for d in (distance - 30e-3, distance + 1e-6))
    for _ in range(40):
        middle = 0.5 * (low + high)
        short = middle < distance - profile(middle * np.hypot(x, y))
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize("rule", ["mean", pytest.param("either", marks=pytest.mark.slow)])
@settings(max_examples=8)
@given(
    distance=st.sampled_from([0.15, 0.2, 0.3]),
    focal=st.sampled_from([320.0, 480.0]),
    radius=st.sampled_from([15e-3, 25e-3]),
)
def test_classes_depend_on_neither_distance_nor_pitch(surfaces, rule, distance, focal, radius):
    """The same surface, without noise, is sorted alike wherever the camera stands and however fine its pixels are."""
    angle, grid = np.radians(35), np.meshgrid(*[np.arange(-28e-3, 28.1e-3, 1e-3)] * 2)
    profile = surfaces.sphere_press(radius, angle)
    sorted_at = []
    for z, f in ((0.2, 480.0), (distance, focal)):
        half = int(35e-3 / z * f)
        lens = surfaces.camera(2 * half + 1, 2 * half + 1, f)
        points, valid = deproject(seen_from(z, profile, lens), lens)
        labels = segment(to_membrane(points, z), valid, rule=rule)
        height = profile(np.hypot(*grid))
        columns, rows = (np.rint(half + a / (z - height) * f).astype(int) for a in grid)
        sorted_at.append(labels[np.clip(rows, 0, 2 * half), np.clip(columns, 0, 2 * half)])
    assert (sorted_at[0] == sorted_at[1]).mean() > 0.95


@pytest.mark.parametrize(
    ("noise", "off"), [(Noise(white=0.02e-3), 0.1), (Noise(white=0.3e-3), 0.1), (Noise(correlated=1e-3, count=8), 0.15)]
)
def test_confidence_is_the_share_of_labels_that_are_right(noise, off):
    """A small contact is labelled too wide, as smoothed curvature reaches further than what touches."""
    stated, right = [], []
    for shape in (Ball(0.012), Ball(0.03), Cylinder(0.015), Cylinder(0.03)):
        view = seen(BodyPress(shape, 0.03, 0.010))
        found = find_contact(observe(view, noise, 1))
        touching = found.labels == CONTACT
        stated.append(found.confidence[touching].mean())
        right.append(view.touching[touching].mean())
        assert found.confidence[found.labels != INVALID].mean() > 0.85
        assert (found.confidence[found.labels == INVALID] == 0.0).all()
    assert np.mean(stated) == pytest.approx(np.mean(right), abs=off)
    if noise.white:
        assert np.corrcoef(stated, right)[0, 1] > 0.8


@pytest.mark.parametrize("shape", [Ball(0.03), Cylinder(0.015)])
def test_of_a_slack_sheet_whose_skirt_passes_for_contact_no_contact_is_sure(shape):
    found = find_contact(observe(seen(BodyPress(shape, 0.0, 0.010)), Noise(white=0.02e-3), 1))
    assert found.confidence[found.labels == CONTACT].mean() < 0.6


def test_under_correlated_noise_the_top_is_found_by_height_and_little_is_certain(surfaces):
    lens = surfaces.camera()
    depth = surfaces.render(surfaces.disc_press(10e-3, 10e-3), lens)
    r = surfaces.distance_from_axis(depth, lens)
    white = np.random.default_rng(0).standard_normal(depth.shape)
    noisy = depth + gaussian_filter(white, 3.0) * 6 * np.sqrt(np.pi) * 0.6e-3
    found = classify(*as_seen(surfaces, noisy, "membrane", noise=0.0))
    assert found.noise == pytest.approx(0.6e-3, rel=0.15)
    assert overlap(found.labels == CONTACT, r < 10e-3) > 0.5
    edge = (r > 8e-3) & (r < 12e-3)
    assert np.median(found.confidence[edge]) < 0.95


@pytest.mark.parametrize(("shape", "stretch"), [(Cylinder(0.02), 0.06), (Ball(0.03), 0.06), (Cylinder(0.02), 0.03)])
@pytest.mark.parametrize(("white", "shared", "length"), [(0.5e-3, 0.15e-3, 3.0), (0.3e-3, 0.1e-3, 4.0)])
def test_white_noise_does_not_hide_that_pixels_share_some(shape, stretch, white, shared, length):
    """Most of a taut membrane was taken for contact in up to half of such frames, where nothing of it lies flat."""
    view = seen(BodyPress(shape, stretch, 0.008))
    wide = []
    for seed in range(1000, 1006):
        found = find_contact(observe(view, Noise(white=white, correlated=shared, kernel=length), seed))
        wide.append(np.count_nonzero(found.labels == CONTACT) / np.count_nonzero(view.touching))
    assert np.count_nonzero(np.array(wide) > 3) <= 1


@pytest.mark.parametrize("height", [60, 213])
def test_a_quiet_frame_with_little_flat_membrane_keeps_the_whole_cap(surfaces, height):
    """Bends where the skirt ends must not pass for noise."""
    lens = surfaces.camera(height, 333)
    depth = surfaces.render(surfaces.sphere_press(30e-3, np.radians(24)), lens)
    truth = surfaces.distance_from_axis(depth, lens) < 30e-3 * np.sin(np.radians(24))
    points, valid = as_seen(surfaces, depth, "membrane", noise=0.07e-3)
    assert overlap(segment(points, valid) == CONTACT, truth & valid) > (0.93 if height > 100 else 0.8)
