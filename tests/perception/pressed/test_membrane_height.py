"""The height of a sphere's top by the whole membrane, against shapes whose height is known."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from stretch_bt.accuracy.force.hands import TrueHand
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.perception.pressed.height import (
    FORM_OFF,
    OFFSET,
    SPAN,
    STEEP,
    STEEPER,
    MountedMembrane,
    membrane_height,
    mounted_membrane,
)
from stretch_bt.perception.pressed.table import read_shapes
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.hanging import hang, lowest
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.units import Estimate

SIDE = 160
HANG = Estimate(6e-4, 3e-5)
NOISE = 5e-5  # m, of a pixel


def shape(radius, span, depth, beside=(0.0, 0.0), offset=0.0, hangs=HANG.value, scale=1.0, thickness=0.002):
    """Return points (SIDE, SIDE, 3) of a membrane of the table."""
    y, x = np.meshgrid(np.linspace(-0.055, 0.055, SIDE), np.linspace(-0.045, 0.045, SIDE), indexing="ij")
    form = read_shapes().at(span, thickness).form(radius, depth)
    lifted, hung = form.heights((x - beside[0]).ravel(), (y - beside[1]).ravel())
    z = (depth * lifted + hangs * hung).reshape(x.shape) + offset
    return scale * np.stack([x, y, z], axis=-1)


def told(
    points, radius, span, depth, *, curvature_sd=0.03, gauge=0.1, width=0.09, thickness=0.002, hang=HANG, valid=None
):
    valid = np.ones(points.shape[:2], dtype=bool) if valid is None else valid
    curvature = Estimate(1 / radius, curvature_sd / abs(radius))
    return membrane_height(points, valid, MountedMembrane(gauge, width, thickness, span, hang), curvature, 0.95 * depth)


@settings(max_examples=20)
@given(
    st.floats(0.015, 0.05),
    st.floats(0.006, 0.09),
    st.floats(1.5e-3, 14e-3),
    st.tuples(st.floats(-2e-3, 2e-3), st.floats(-2e-3, 2e-3)),
    st.floats(-2e-5, 2e-5),
    st.integers(0, 99),
)
def test_height_within_its_deviation_whatever_the_press(radius, span, depth, beside, offset, seed):
    points = shape(radius, span, depth, beside, offset)
    points[..., 2] += np.random.default_rng(seed).normal(0, NOISE, points.shape[:2])
    height = told(points, radius, span, depth)
    assert abs(height.value - depth) < 5 * math.hypot(height.sd, FORM_OFF)
    # Of other rubbers on a steep flank, which grows with slope and span, and of this frame: less than the camera's own offset.
    steep = STEEPER * max(math.sqrt(depth / (2 * radius)) - STEEP, 0.0) * span / SPAN
    assert 0.98 * steep < height.sd < math.hypot(1.02 * steep, OFFSET)


@pytest.mark.parametrize(("sd", "alike"), [(3e-4, 0.0), pytest.param(1e-4, 3.0, marks=pytest.mark.slow)])
def test_its_deviation_is_that_of_many_draws(sd, alike):
    off = []
    for seed in range(60):
        random = np.random.default_rng(seed)
        radius, hangs = 0.03 / (1 + random.normal(0, 0.03)), random.normal(HANG.value, HANG.sd)
        points = shape(radius, 0.014, 4e-3, offset=random.normal(0, OFFSET), hangs=hangs)
        noise = gaussian_filter(random.normal(0, 1, points.shape[:2]), alike, mode="wrap")
        points[..., 2] += sd * noise / noise.std()
        height = told(points, 0.03, 0.014, 4e-3)
        off.append((height.value - 4e-3) / height.sd)
    assert 0.85 < float(np.sqrt(np.mean(np.square(off)))) < 1.13


def test_a_membrane_of_another_size_has_the_same_shape():
    small = shape(0.03, 0.02, 6e-3, scale=0.5)
    given = {"gauge": 0.05, "width": 0.045, "thickness": 0.001, "hang": Estimate(HANG.value / 2, HANG.sd / 2)}
    height = told(small, 0.015, 0.01, 3e-3, **given)
    assert height.value == pytest.approx(3e-3, abs=1e-5)


@pytest.mark.parametrize(("gauge", "thickness"), [(0.09, 0.0027), (0.1, 0.003), (0.07, 0.0021), (0.06, 6e-4)])
def test_a_membrane_as_thin_or_as_thick_as_the_table_goes_is_known_at_any_size(gauge, thickness):
    scale = gauge / 0.1
    points = shape(0.03, 0.02, 6e-3, scale=scale, thickness=round(thickness / scale, 9))
    given = {"gauge": gauge, "width": 0.9 * gauge, "thickness": thickness, "hang": Estimate(HANG.value * scale, 3e-5)}
    assert told(points, 0.03 * scale, 0.02 * scale, 6e-3 * scale, **given).value == pytest.approx(
        6e-3 * scale, abs=1e-5
    )


def test_flying_and_missing_pixels_are_borne():
    points, random = shape(0.03, 0.014, 6e-3), np.random.default_rng(1)
    points[random.random(points.shape[:2]) < 0.05, 2] += 0.01
    valid = random.random(points.shape[:2]) > 0.2
    points[~valid] = np.nan
    assert told(points, 0.03, 0.014, 6e-3, valid=valid).value == pytest.approx(6e-3, abs=4e-5)


@pytest.mark.parametrize(("seed", "depth"), [(1, 2e-3), (1, 8e-3), (2, 2e-3), (3, 2e-3)])  # 2.0, 1.6 and 2.4 mm thick
def test_a_hand_with_friction_softening_and_another_rubber(seed, depth):
    hand = TrueHand.drawn(seed)
    sheet = hand.sheet()
    load = Load(Sphere(0.06), 0.0, depth, (0.0, 0.0), (0.0, 0.0), lowest(sheet, 0.0))
    points = solve(sheet, load, Settings()).shape.points(2 * SIDE, 2 * SIDE)
    hangs = -float(hang(sheet, 0.0).points(3, 3)[1, 1, 2])
    height = told(
        points, 0.03, hand.mount_prestretch, depth, thickness=hand.thickness, hang=Estimate(hangs, 0.05 * hangs)
    )
    assert height.value == pytest.approx(depth, abs=2e-5)


FLAT = np.where(
    np.hypot(*np.meshgrid(np.linspace(-0.045, 0.045, SIDE), np.linspace(-0.055, 0.055, SIDE))) < 0.015, 6e-3, 0.0
)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"points": shape(0.03, 0.014, 6e-3, beside=(9e-3, 0.0))}, "no press of a sphere in the middle"),
        ({"points": np.dstack([shape(0.03, 0.014, 6e-3)[..., :2], FLAT])}, "no press|settle|known"),
        ({"width": 0.12}, "sides as"),
        ({"span": 0.2}, "span"),
        ({"thickness": 0.004}, "thickness"),
        ({"depth": 1e-4, "points": shape(0.03, 0.014, 1e-3)}, "depth"),
        ({"radius": 0.2}, "diameter"),
        ({"radius": -0.03}, "convex"),
        ({"gauge": 0.02, "width": 0.018}, "100 mm long"),
        ({"curvature_sd": 1e6, "points": shape(0.03, 0.014, 6e-3)[::-1] * [1, 1, -1]}, "shapes|settle|no press"),
        ({"valid": np.zeros((SIDE, SIDE), dtype=bool)}, "too little"),
        ({"points": np.repeat(shape(0.03, 0.014, 6e-3)[72:88], 10, axis=0)}, "too little"),
    ],
)
def test_what_is_no_such_press_is_refused(change, reason):
    given = {"points": shape(0.03, 0.014, 6e-3), "radius": 0.03, "span": 0.014, "depth": 6e-3, **change}
    with pytest.raises(IllConditioned, match=reason):
        told(**given)


@pytest.mark.parametrize(
    "change", [{"curvature_sd": 0.0}, {"curvature_sd": math.nan}, {"valid": np.ones((SIDE, 3), dtype=bool)}]
)
def test_what_does_not_go_together_is_invalid(change):
    with pytest.raises(InvalidInput):
        told(shape(0.03, 0.014, 6e-3), 0.03, 0.014, 6e-3, **change)


def test_heights_that_are_no_numbers_are_passed_over():
    points = shape(0.03, 0.014, 6e-3)
    points[::8, ::8, 2] = np.inf
    points[4::8, ::8, 2] = np.nan
    assert told(points, 0.03, 0.014, 6e-3).value == pytest.approx(6e-3, abs=1e-5)


def test_a_tenser_membrane_hangs_less_in_the_same_proportion():
    hangs = [mounted_membrane(0.1, 0.09, 0.002, 0.012, stretch, HANG).hang for stretch in (0.0, 0.02, 0.06)]
    assert hangs[0] == HANG
    assert hangs[0].value > hangs[1].value > hangs[2].value
    assert hangs[2].sd / hangs[2].value == pytest.approx(HANG.sd / HANG.value)
