import numpy as np
import pytest

from stretch_bt.accuracy.perception import view
from stretch_bt.accuracy.perception.noise import CLEAN, Noise, frames, observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, BodyPress, SheetView, seen
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import press


@pytest.fixture(scope="module")
def cylinder() -> SheetView:
    return seen(BodyPress(Cylinder(0.02), 0.03, 0.008, (0.004, -0.006)))


def points_of(view: SheetView) -> np.ndarray:
    return to_membrane(deproject(view.depth, CAMERA)[0], PLANE_DISTANCE)


def test_every_ray_ends_on_the_sheet(cylinder: SheetView) -> None:
    solved = press(Cylinder(0.02), 0.03, 0.008, at=(0.004, -0.006), mesh=1e-3).detail
    points = points_of(cylinder)[10:-10:7, 10:-10:7].reshape(-1, 3)
    points = points[np.isfinite(points[:, 2])]
    height = solved.shape.height(points[:, 0], points[:, 1])
    # the sheet is triangulated here, and its default elements differ a little
    assert np.abs(height - points[:, 2]).max() < 0.15e-3
    assert np.median(np.abs(height - points[:, 2])) < 0.01e-3


def test_a_flat_face_is_seen_where_it_is(cylinder: SheetView) -> None:
    points = points_of(cylinder)[cylinder.touching]
    assert points[:, :2].mean(axis=0) == pytest.approx([0.004, -0.006], abs=0.1e-3)
    assert 2 * cylinder.radius == pytest.approx(0.0195, abs=0.5e-3)  # the sheet leaves a rim of 1 mm before its end
    assert np.median(points[:, 2]) == pytest.approx(0.008, abs=0.06e-3)


def test_contact_with_a_sphere_lies_on_it() -> None:
    view = seen(BodyPress(Sphere(0.03), 0.03, 0.008))
    points = points_of(view)[view.touching]
    off = np.linalg.norm(points - [0.0, 0.0, 0.008 - 0.015], axis=1) - 0.015
    assert np.abs(off).max() < 0.1e-3
    across, along = np.ptp(points[:, :2], axis=0)
    assert across > 1.5 * along


def test_noise_has_the_size_and_the_memory_that_it_says() -> None:
    flat = SheetView(
        BodyPress(Sphere(0.02), 0.0, 0.0), np.full((333, 213), 0.2, np.float32), np.zeros((333, 213), np.bool_), 0.0
    )
    noise = Noise(correlated=1e-3, dropouts=0.0, count=8)
    stack = np.array([f.depth for f in frames(flat, noise, 3)], np.float64) - 0.2
    assert stack.std() == pytest.approx(1e-3, rel=0.05)
    beside = [(stack[:, :, lag:] * stack[:, :, : stack.shape[2] - lag]).mean() / stack.var() for lag in (1, 3, 6)]
    assert beside == pytest.approx([np.exp(-(lag**2) / 36) for lag in (1, 3, 6)], abs=0.05)
    assert (stack[1:] * stack[:-1]).mean() / stack.var() == pytest.approx(0.6, abs=0.05)
    assert np.std(observe(flat, noise, 3).depth - np.float32(0.2)) == pytest.approx(0.62e-3, rel=0.08)
    assert np.abs(observe(flat, CLEAN, 1).depth - 0.2).max() < 5e-6


def test_bodies_of_many_numbers_are_kept_apart(monkeypatch, tmp_path):
    """Two height fields of one size showed the view of the first."""
    monkeypatch.setattr(view, "cache_folder", lambda: tmp_path / "kernels")
    low, high = (HeightField(z * np.ones((9, 9)), 1e-3) for z in (0.01, 0.02))
    names = {view._file(BodyPress(body, 0.0, 0.005)) for body in (low, high, HeightField(low.heights.copy(), 1e-3))}
    assert len(names) == 2
