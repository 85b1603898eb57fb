import math

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.parse import parse_indenter
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.ring import Ring
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.shapes import pyramid, triangular_prism
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.turned import Turned, turn
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.indenters.wire_polygon import WirePolygon


def field(surface, count=51, pitch=0.5e-3):
    """Return the height field of a function of x and y, m, over a square around the origin."""
    x = (np.arange(count) - (count - 1) / 2) * pitch
    return HeightField(surface(*np.meshgrid(x, x)), pitch)


BUMP = field(lambda x, y: 0.008 * np.exp(-((x - 0.002) ** 2 + 1.6 * (y + 0.001) ** 2 + 0.4 * x * y) / 6e-5))
SHAPES = [
    Sphere(0.02),
    Cylinder(0.02),
    Cone(math.pi / 4),
    Cube(0.02),
    Box(0.01, 0.016, 0.4),
    Wire(0.0015, 0.03, 0.4),
    BUMP,
    Turned(BUMP, 0.7),
    HalfCylinder(0.012, 0.02),
    Ring(0.002, 0.02),
    WirePolygon(0.002, 0.02),
    WirePolygon(0.002, 0.02, 4, 0.003),
    triangular_prism(0.02, 0.012, 0.01),
    pyramid(0.02, 0.012),
    Turned(Box(0.01, 0.016), 0.4),
]
TILTS = [(0.0, 0.0), (0.2, -0.3)]


def around(body, rng, count=400):
    """Return points near the upper surface of a body."""
    points = rng.uniform(-0.014, 0.014, (count, 3)) + body.origin
    gap = body.gap(points)
    near = np.abs(gap.distance) < 0.3 * body.indenter.feature
    return points[near], gap.normal[near]


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_normal_and_curvature_are_derivatives_of_the_distance(shape, tilt):
    (body,) = place(shape, (0.003, -0.002), tilt, 0.01)
    points, _ = around(body, np.random.default_rng(1), 40_000)
    points = points[:300]
    step = 1e-7
    gap = body.gap(points)
    slope = np.stack(
        [(body.gap(points + e).distance - body.gap(points - e).distance) / (2 * step) for e in step * np.eye(3)], axis=1
    )
    bend = np.stack(
        [(body.gap(points + e).normal - body.gap(points - e).normal) / (2 * step) for e in step * np.eye(3)], axis=1
    )
    full = gap.curvature[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    assert len(points) > 30
    # faces, fillets and flanks meet with a jump of the curvature: few points straddle one
    smooth = np.abs(bend - full).max(axis=(1, 2)) < 1e-3 * max(np.abs(full).max(), 1.0)
    assert smooth.mean() > 0.98
    np.testing.assert_allclose(slope, gap.normal, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(gap.normal, axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize(
    "shape",
    [pytest.param(s, marks=[pytest.mark.slow] * (isinstance(s, Turned) and s.indenter is BUMP)) for s in SHAPES],
    ids=repr,
)
def test_the_highest_point_is_at_the_depth(shape, tilt):
    (body,) = place(shape, (0.0, 0.0), tilt, 0.01)
    rng = np.random.default_rng(2)
    points = body.origin + rng.uniform(-0.02, 0.02, (200_000, 3))
    inside = points[body.gap(points).distance < 0]
    assert inside[:, 2].max() <= 0.01 + 1e-12
    above = np.column_stack([points[:, :2], np.full(len(points), 0.01)])
    assert body.gap(above).distance.min() == pytest.approx(0.0, abs=2e-4)
    assert body.gap(above).distance.min() > -1e-12


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_distance_changes_no_faster_than_the_place(shape):
    assert isinstance(shape, Indenter)
    rng = np.random.default_rng(3)
    one, other = rng.uniform(-0.03, 0.03, (2, 5000, 3))
    change = np.abs(shape.gap(one).distance - shape.gap(other).distance)
    assert np.all(change <= np.linalg.norm(one - other, axis=1) * (1 + 1e-9))


def test_a_group_keeps_its_parts_apart_and_its_top_at_the_depth():
    group = Several((Part(Sphere(0.01), (-0.015, 0.0)), Part(Sphere(0.02), (0.015, 0.0), 0.002)))
    left, right = place(group, (0.0, 0.01), (0.0, 0.0), 0.008)
    assert (left.top, right.top) == pytest.approx((0.008, 0.006))
    assert left.origin[:2] == pytest.approx([-0.015, 0.01])
    assert right.origin[:2] == pytest.approx([0.015, 0.01])


def test_turning_moves_each_point_with_the_body():
    c, s = math.cos(0.4), math.sin(0.4)
    points = np.random.default_rng(4).uniform(-0.02, 0.02, (500, 3))
    turned = points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    plain, moved = Box(0.01, 0.016), turn(Box(0.01, 0.016), 0.4)
    np.testing.assert_allclose(moved.gap(turned).distance, plain.gap(points).distance, atol=1e-15)
    np.testing.assert_allclose(moved.gap(points).distance, Box(0.01, 0.016, 0.4).gap(points).distance, atol=1e-15)


def test_turning_a_group_turns_the_places_of_its_parts():
    group = turn(Several((Part(Sphere(0.01), (0.01, 0.0)), Part(Cube(0.02), (0.0, 0.02), 0.002))), math.pi / 2)
    assert group.parts[0] == Part(Sphere(0.01), pytest.approx((0.0, 0.01)), 0.0)
    assert group.parts[1].indenter == Turned(Cube(0.02), math.pi / 2)
    assert group.parts[1].at == pytest.approx((-0.02, 0.0))


def test_bodies_of_revolution_stay_as_they_are_and_turns_add_up():
    assert turn(Sphere(0.02), 1.0) == Sphere(0.02)
    assert turn(turn(Cube(0.02), 0.2), 0.3) == Turned(Cube(0.02), 0.5)
    with pytest.raises(InvalidInput):
        turn(Cube(0.02), math.inf)


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("sphere:20mm", Sphere(0.02)),
        ("cylinder: 20 mm", Cylinder(0.02)),
        ("cylinder:2cm:0.5mm", Cylinder(0.02, 0.0005)),
        ("cone:45deg", Cone(math.pi / 4)),
        ("cone:45deg:1mm", Cone(math.pi / 4, 0.001)),
        ("cube:40mm", Cube(0.04)),
    ],
)
def test_parsing(text, shape):
    assert repr(parse_indenter(text)) == repr(shape)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("spere:20mm", "sphere"),
        ("sphere", "sphere:20mm"),
        ("sphere:20", "20 mm"),
        ("sphere:20mm:1mm", "sizes"),
        ("cube:-4mm", "above 0"),
        ("cone:95deg", "below"),
        ("cylinder:2mm:3mm", "at most"),
        ("cone:45mm", "Angle"),
        ("", "choose"),
    ],
)
def test_parsing_says_what_to_write(text, says):
    with pytest.raises(InvalidInput, match=says):
        parse_indenter(text)


@pytest.mark.parametrize("arguments", [((math.nan, 0.0), (0.0, 0.0), 0.01), ((0.0, 0.0), (1.6, 0.0), 0.01)])
def test_bad_places(arguments):
    with pytest.raises(InvalidInput):
        place(Sphere(0.02), *arguments)


def test_a_cone_tilts_less_than_its_angle():
    with pytest.raises(InvalidInput, match="flank"):
        place(Cone(0.3), (0.0, 0.0), (0.4, 0.0), 0.01)
