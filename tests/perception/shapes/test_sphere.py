import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned
from stretch_bt.hardcases.strategies.fits import POINTS
from stretch_bt.perception import fit_sphere
from stretch_bt.perception.shapes.sight import camera_of
from stretch_bt.perception.shapes.sphere import SphereSurface


def seen(points, noise, rng):
    return points + np.column_stack([np.zeros((len(points), 2)), rng.normal(0.0, noise, len(points))])


@given(
    st.tuples(st.floats(-1, 1), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-0.4, 0.4)),
    st.integers(0, 2**31),
)
def test_the_jacobian_is_the_derivative_of_the_model(parameters, seed):
    x, y = np.random.default_rng(seed).uniform(-0.3, 0.3, (2, 20))
    q = np.array(parameters)
    _, jacobian = SphereSurface(q).heights(x, y)
    for k in range(4):
        step = np.eye(4)[k] * 1e-6
        numeric = (SphereSurface(q + step).heights(x, y)[0] - SphereSurface(q - step).heights(x, y)[0]) / 2e-6
        np.testing.assert_allclose(jacobian[k], numeric, atol=1e-6)


@pytest.mark.parametrize(
    ("noise", "outliers"),
    [
        pytest.param(0.3e-3, 0.0, marks=pytest.mark.slow),
        (1e-3, 0.0),
        (0.3e-3, 0.3),
        pytest.param(1e-3, 0.3, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(("radius", "angle"), [(5e-3, 60), (15e-3, 30), (30e-3, 15)])
def test_curvature_is_at_its_bound_and_its_sd_is_honest(surfaces, noise, outliers, radius, angle):
    rng = np.random.default_rng(3)
    points = surfaces.cap(radius, np.radians(angle))
    bound = surfaces.curvature_bound(points, radius, noise)
    fits = []
    for _ in range(100):
        cloud = seen(points, noise, rng)
        hit = rng.random(len(cloud)) < outliers
        cloud[hit, 2] += rng.uniform(3e-3, 20e-3, hit.sum()) * rng.choice([-1, 1], hit.sum())
        fits.append(fit_sphere(cloud))
    value = np.array([f.curvature for f in fits])
    stated = np.array([f.curvature_sd for f in fits])
    # A deviation from 100 draws is itself uncertain by 7 %, a mean by a tenth of the bound.
    assert value.std() < 1.3 * 1.14 * bound
    assert abs(value.mean() - 1 / radius) < (0.3 + 0.2) * bound
    assert stated.mean() / value.std() == pytest.approx(1.0, abs=0.3)


def test_center_and_radius_deviations_are_honest(surfaces):
    rng = np.random.default_rng(4)
    points = surfaces.cap(12e-3, np.radians(40)) + np.array([3e-3, -2e-3, 5e-3])
    fits = [fit_sphere(seen(points, 0.3e-3, rng)) for _ in range(100)]
    centers = np.array([f.center for f in fits])
    np.testing.assert_allclose(centers.mean(axis=0), [3e-3, -2e-3, 5e-3], atol=0.1e-3)
    np.testing.assert_allclose(np.mean([f.center_sd for f in fits], axis=0), centers.std(axis=0), rtol=0.3)
    assert np.mean([f.radius_sd for f in fits]) == pytest.approx(np.std([f.radius for f in fits]), rel=0.3)


@settings(max_examples=50)
@given(
    radius=st.floats(1e-4, 1e3),
    angle=st.floats(15, 60),
    axis=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)).filter(lambda a: np.linalg.norm(a) > 0.1),
    convex=st.booleans(),
)
def test_an_exact_sphere_is_found_at_any_scale_direction_and_sign(surfaces, radius, angle, axis, convex):
    points = surfaces.cap(1.0, np.radians(angle), pitch=0.06)
    toward = np.array(axis) / np.linalg.norm(axis)
    side = np.cross(toward, [1.0, 0.0, 0.0] if abs(toward[0]) < 0.7 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    rotated = radius * points @ np.array([side, np.cross(toward, side), toward])
    ray = -toward if convex else toward
    fit = fit_sphere(rotated, rays=np.tile(ray, (len(points), 1)))
    assert fit.radius == pytest.approx(radius, rel=1e-5)
    assert np.sign(fit.curvature) == (1 if convex else -1)
    np.testing.assert_allclose(fit.center, 0.0, atol=1e-5 * radius)


def test_camera_rays_give_the_same_sphere_as_the_default_direction(surfaces):
    points = surfaces.cap(15e-3, np.radians(40))
    rays = points - [0, 0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    assert fit_sphere(points, rays=rays).radius == pytest.approx(fit_sphere(points).radius, rel=1e-6)


def test_noise_along_the_rays_of_a_pinhole_does_not_bias(surfaces):
    points = surfaces.cap(30e-3, 0.6)
    rays = points - [0, 0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    bound = surfaces.curvature_bound(points, 30e-3, 1e-3)
    rng = np.random.default_rng(2)
    noise = rng.normal(0.0, 1e-3, (24, len(points), 1))
    curvatures = [fit_sphere(points + rays / rays[:, 2:] * n, rays=rays).curvature for n in noise]
    assert (
        abs(np.mean(curvatures) - 1.0 / 30e-3) < 0.7 * bound
    )  # five deviations of the mean of 24; left out, it is 1.5


def test_camera_is_where_rays_meet(surfaces):
    points = surfaces.cap(15e-3, 0.6) + [3e-3, -2e-3, 0.0]
    rays = points - [1e-3, 2e-3, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    assert camera_of(points, rays) == pytest.approx([1e-3, 2e-3, 0.2], abs=1e-9)
    assert camera_of(points, np.tile([0.0, 0.0, -1.0], (len(points), 1))) is None


def test_known_noise_bounds_the_deviation_from_below(surfaces):
    points = surfaces.cap(15e-3, np.radians(30))
    bound = surfaces.curvature_bound(points, 15e-3, 0.3e-3)
    assert fit_sphere(points, noise=0.3e-3).curvature_sd == pytest.approx(bound, rel=0.05)


@settings(max_examples=100)
@given(POINTS)
def test_any_points_give_finite_numbers_or_a_refusal(points):
    try:
        fit = fit_sphere(points)
    except IllConditioned:
        return
    assert fit.radius > 0
    assert abs(fit.curvature) >= 3 * fit.curvature_sd
    assert np.isfinite([fit.radius, fit.radius_sd, fit.curvature_sd, *fit.center, *fit.center_sd]).all()


@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-4])
def test_a_hemisphere_is_measured_without_its_steepest_points_and_refused_with_them(noise):
    """The refusal once said that the radius is one of noise."""
    rng = np.random.default_rng(0)
    points = rng.standard_normal((4000, 3))
    points *= 0.02 / np.linalg.norm(points, axis=1)[:, None]
    steep = points[:, 2] < 0.02 * np.cos(np.radians(80))
    points[:, 2] += noise * rng.standard_normal(4000)
    with pytest.raises(IllConditioned, match="leave out those whose normal is more than 80 degrees from the view"):
        fit_sphere(points[points[:, 2] > 0])
    fit = fit_sphere(points[~steep])
    assert abs(fit.radius - 0.02) <= max(3 * fit.radius_sd, 1e-12)


@given(k=st.floats(-3.0, 3.0), step=st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4))
def test_a_step_changes_a_curvature_by_half_at_most(k, step):
    before = SphereSurface(np.array([0.0, 0.1, -0.1, k]))
    after, taken = before.moved(np.array(step))
    assert abs(after.q[3] - k) <= 0.5 * max(abs(k), 0.05) * (1 + 1e-12)
    np.testing.assert_allclose(after.q, before.q + taken)
    assert np.linalg.norm(np.cross(taken[:3], step[:3])) <= 1e-9 * np.linalg.norm(taken) * np.linalg.norm(step)


def test_noise_on_half_a_ball_makes_no_smaller_ball():
    """A sphere that its points do not fit on, seen from the camera, is one of their noise."""
    refused = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        n, radius = rng.integers(12, 60), rng.choice([1e-3, 2e-3])
        x, y = rng.uniform(-radius, radius, (2, n))
        z = np.sqrt(np.maximum(radius**2 - x * x - y * y, 0.0)) + rng.normal(0.0, rng.choice([2e-4, 5e-4]), n)
        try:
            sphere = fit_sphere(np.column_stack([x, y, z]))
        except IllConditioned as error:
            refused += "spread wider than" in error.reason
            continue
        away = np.hypot(x - sphere.center[0], y - sphere.center[1])
        assert np.quantile(away, 0.9) <= 1.05 * sphere.radius
    assert refused > 3
