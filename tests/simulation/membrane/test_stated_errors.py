"""Errors of forces beside what is stated of them; `python -m benchmarks.membrane_errors` draws many more presses."""

import math

import numpy as np
import pytest

from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.settings import Settings

# indenter, stretch, depth, place, force on elements 0.3 times as long that grow by 1.35, 0.2 times under cones
PRESSES = {
    "ordinary": (
        ("sphere:10mm", 0.01, 0.003, (0, 0), (0.0, 0.0, 0.05502)),
        ("sphere:20mm", 0.03, 0.008, (0.005, 0.003), (-0.00429, 0.00287, 0.52198)),
        ("sphere:30mm", 0.06, 0.012, (0, 0), (0.0, 0.0, 1.43267)),
        ("sphere:15mm", 0.08, 0.006, (-0.004, 0.007), (0.00291, 0.00296, 0.54185)),
        ("sphere:25mm", 0.02, 0.010, (0.002, -0.010), (-0.00250, -0.01614, 0.62375)),
        ("sphere:12mm", 0.05, 0.005, (0, 0.006), (0.0, 0.00191, 0.32951)),
        ("sphere:28mm", 0.077, 0.002, (0, 0), (0.0, 0.0, 0.15360)),
        ("sphere:22mm", 0.04, 0.004, (0.006, 0.006), (-0.00144, 0.00133, 0.24559)),
    ),
    "rims": (
        ("cylinder:20mm", 0.03, 0.008, (0, 0), (0.0, 0.0, 0.83335)),
        ("cube:20mm", 0.05, 0.010, (0.004, 0.004), (-0.01313, 0.00935, 1.50443)),
        ("cylinder:12mm", 0.06, 0.005, (0.003, -0.006), (-0.00177, -0.00238, 0.51761)),
        ("cube:30mm", 0.02, 0.006, (0, 0), (0.0, 0.0, 0.69719)),
        ("cube:15mm", 0.07, 0.012, (-0.005, 0.002), (0.02391, 0.00544, 1.76878)),
        ("cylinder:28mm", 0.04, 0.003, (0.005, 0.005), (-0.00133, 0.00107, 0.41970)),
    ),
    "rounded edges": (
        (Box(0.0114, 0.0114, 0.0, 0.0057), 0.037, 0.011, (0, 0), (0.0, 0.0, 0.81191)),
        (Box(0.0068, 0.0068, 0.0, 0.0034), 0.037, 0.0037, (0, 0), (0.0, 0.0, 0.16893)),
        (Box(0.0146, 0.0146, 0.0, 0.0073), 0.061, 0.0077, (0, 0), (0.0, 0.0, 0.66084)),
        (Box(0.0143, 0.0347, 0.0, 0.00715), 0.059, 0.009, (0, 0), (0.0, 0.0, 1.00286)),
        (Box(0.0288, 0.0128, 0.0, 0.0064), 0.072, 0.0048, (0, 0), (0.0, 0.0, 0.68043)),
        (Box(0.0082, 0.0216, 0.0, 0.0041), 0.078, 0.0026, (0, 0), (0.0, 0.0, 0.20260)),
        (Box(0.0313, 0.0250, 0.0, 0.0070), 0.063, 0.0078, (0, 0), (0.0, 0.0, 1.27510)),
        (Cube(0.0144, 0.0047), 0.059, 0.009, (0, 0), (0.0, 0.0, 0.95494)),
        (HalfCylinder(0.0327, 0.0364), 0.061, 0.0025, (0, 0), (0.0, 0.0, 0.44334)),
    ),
    "slack": (
        ("sphere:20mm", 0.0, 0.004, (0.030, 0.028), (-0.00020, 0.00050, 0.00693)),
        ("sphere:12mm", 0.003, 0.012, (0.028, -0.004), (-0.02790, -0.00347, 0.18013)),
        ("sphere:25mm", 0.001, 0.006, (-0.020, 0.030), (0.00149, 0.00722, 0.06858)),
        ("sphere:20mm", 0.003, 0.007, (-0.027, 0.002), (0.00524, 0.00039, 0.07573)),
    ),
    "steep cones": (
        ("cone:60deg", 0.03, 0.006, (0, 0), (0.0, 0.0, 0.23470)),
        ("cone:70deg", 0.06, 0.007, (-0.009, -0.001), (0.00322, -0.00337, 0.36369)),
        ("cone:67deg", 0.01, 0.0115, (0.006, 0.012), (-0.00384, 0.01222, 0.35456)),
        ("cone:65deg", 0.08, 0.005, (0, 0), (0.0, 0.0, 0.27748)),
        ("cone:60deg", 0.0238, 0.00985, (-0.0063, 0.010), (0.0048, 0.0093, 0.4230)),
    ),
}


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=[pytest.mark.slow] * (k in ("rims", "steep cones"))) for k in PRESSES]
)
def test_a_stated_error_is_the_size_of_the_error(kind):
    found = [(press(*case, at=at).detail, force) for *case, at, force in PRESSES[kind]]
    errors = np.array([(p.force - force) / p.force_error for p, force in found])[:, 2]
    assert 0.7 < math.sqrt(np.mean(errors**2)) < 1.3
    assert np.abs(errors).max() < 2.5
    across = np.array([(p.force - force)[:2] / p.side_error for p, force in found])
    assert np.abs(across).max() < 2.5


@pytest.mark.parametrize(("stretch", "depth"), [(0.03, 0.008), (0.05, 0.001), (0.075, 0.012)])
def test_a_post_whose_edge_takes_its_face_is_a_ball_and_one_with_hardly_a_face_nearly(stretch, depth):
    ball = press(Sphere(0.008), stretch, depth)
    for post in (lambda edge: Box(0.008, 0.008, 0.3, edge), lambda edge: Cube(0.008, edge)):
        found = press(post(0.004), stretch, depth)
        assert (found.force, found.force_error) == pytest.approx((ball.force, ball.force_error), rel=1e-6)
    posts = (lambda edge: Box(0.016, 0.008, 0.0, edge), lambda edge: Box(0.008, 0.008, 0.3, edge))
    for post in (*posts, lambda edge: Cube(0.008, edge), lambda edge: Cylinder(0.008, edge)):
        found, nearly = (press(post(0.004 * (1 - face)), stretch, depth) for face in (0.0, 1e-4))
        told = [(p.force, p.force_error, p.contact.area) for p in (found, nearly)]
        assert told[1] == pytest.approx(told[0], rel=1e-3)


def test_a_post_without_a_face_is_pressed_as_deep_as_one_with_hardly_a_face():
    found, nearly = (press(Box(0.01, 0.01, 0.0, edge), 0.03, 0.0275) for edge in (0.005, 0.004999))
    assert found.force == pytest.approx(nearly.force, rel=1e-3)
    assert found.warnings == nearly.warnings == ("the sheet also presses on the sides of the indenter",)


def test_a_jump_between_meshes_is_within_what_settled_presses_state():
    quick = Settings.within(0.03)
    for depth in (0.5e-3, 2e-3):  # shallower than this, elements are halved
        above, below = (press("sphere:20mm", 0.03, depth * part, settings=quick) for part in (1.001, 0.999))
        jump = abs(above.force / below.force - 1 - 0.003)
        assert jump < 1.5 * math.hypot(above.force_error / above.force, below.force_error / below.force)


def test_forces_across_are_known_less_well_where_the_indenter_stands_on_its_rim():
    level, tilted, ball = (
        press(shape, 0.03, 0.008, tilt=tilt).detail
        for shape, tilt in (("cube:20mm", (0, 0)), ("cube:20mm", (0.1, 0)), ("sphere:20mm", (0.1, 0)))
    )
    shares = [p.side_error / p.force[2] for p in (ball, level, tilted)]
    assert 0 < shares[0] < shares[1] < shares[2] < 0.1


def test_a_ball_about_to_slip_off_an_edge_is_known_less_well():
    found = press("sphere:12.5mm", 0.0211, 0.00977, at=(0.03899, 0.02203), tilt=(-0.0216, 0.0331)).detail
    assert np.hypot(*found.force[:2]) > found.force[2]
    assert found.force_error > 0.1 * found.force[2]
