"""Heights of a sphere's top by the whole membrane, where the run knows how that is mounted, and by the contact elsewhere."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from stretch_bt import open_cell
from stretch_bt.behaviors._readings import FirstTouch, Reading
from stretch_bt.behaviors.records import Mounting, TopReadings, Touch
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import Sphere, deproject, find_contact, to_membrane
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.pressed.table import read_shapes
from stretch_bt.perception.types import UNDEFORMED
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.ports import Role, Status
from stretch_bt.tree.registry import lookup

CAMERA, DISTANCE = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333), 0.2
RADIUS, SPAN, DEEP, LIGHT, HAND = 0.03, 0.014, 8e-3, 2.5e-3, 0.05
MOUNT = Mounting(SPAN, 6e-4, 3e-5)


@cache
def frame(depth, beside=0.0):
    """Return what a camera sees of a press by the table's shapes, with 0.05 mm of noise."""
    form = read_shapes().at(SPAN, 0.002).form(RADIUS, depth)
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    z = np.zeros(u.shape)
    for _ in range(8):  # where a ray meets the membrane
        x, y = (u - CAMERA.cx) / CAMERA.fx * (DISTANCE - z), (v - CAMERA.cy) / CAMERA.fy * (DISTANCE - z)
        lifted, hung = form.heights((x - beside).ravel(), y.ravel())
        z = (depth * lifted + MOUNT.sag * hung).reshape(u.shape)
    seen = DISTANCE - z + np.random.default_rng(1).normal(0, 5e-5, z.shape)
    raw = np.where((np.abs(x) < 0.04) & (np.abs(y) < 0.055), np.round(seen / 1e-5), 0).astype(np.uint16)
    return DepthFrame(raw, 1e-5, CAMERA, 0.0, 0, DISTANCE, hand_height=HAND, stretch=0.0)


def sphere(curvature=1 / RADIUS):
    nowhere = np.zeros(3)
    return Sphere(RADIUS, 5e-4, nowhere, nowhere, curvature, 0.03 / RADIUS)


def ran(name, before=None, **given):
    """Return a node after its one tick, with the readings that were there before."""
    info = lookup(name)
    node = info.cls(f"main/{name}")
    node.context = RunContext()
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(given.get, port.name, port.default)
    for port in info.of(Role.INOUT):
        node.sinks[port.name].value = before
    for _ in node.tick():
        pass
    assert node.status is Status.SUCCESS, node.reason
    return node


def seen_by(mount=MOUNT, *, fitted=None, beside=0.0):
    """Return `track_height` after it looked at a deep press."""
    seen = frame(DEEP, beside)
    return ran("track_height", frame=seen, contact=find_contact(seen), sphere=fitted, mounting=mount)


def observed(node):
    return node.sinks["observed_top"].value


def test_the_whole_membrane_gives_the_height_of_a_sphere():
    node = seen_by(fitted=sphere())
    assert node.sinks["height"].value == pytest.approx(HAND + DEEP, abs=4e-5)
    top = observed(node)
    assert (top.height, top.height_sd) == (node.sinks["height"].value, node.sinks["height"].sd)
    assert top.by_membrane
    assert top.fixed_sd == 0.0, "it has none of the camera's static error"


@pytest.mark.parametrize(
    ("mount", "fitted", "beside"),
    [
        (None, sphere(), 0.0),
        (replace(MOUNT, prestretch=0.0), sphere(), 0.0),
        (MOUNT, None, 0.0),
        (MOUNT, sphere(-1 / RADIUS), 0.0),
        (MOUNT, sphere(), 9e-3),
    ],
    ids=["no mount", "a mount of which only the sag is known", "no sphere", "concave", "off the middle"],
)
def test_the_contact_gives_it_elsewhere(mount, fitted, beside):
    node = seen_by(mount, fitted=fitted, beside=beside)
    assert node.sinks["height"].value == pytest.approx(HAND + DEEP, abs=4e-4)
    assert not observed(node).by_membrane
    assert 0.0 < observed(node).fixed_sd < node.sinks["height"].sd


@pytest.mark.parametrize("fitted", [None, sphere()])
def test_first_touches_are_inferred_as_the_press_is_whatever_noise_is_stated(fitted):
    pressed, seen = observed(seen_by(fitted=fitted)), frame(LIGHT)
    points, valid = deproject(seen)
    touch = FirstTouch(to_membrane(points, DISTANCE), valid, find_contact(seen).labels)
    touched = HAND + DEEP + 8e-4  # the top gave way by as much until the press
    first = Touch(touched + 2e-4, 0.0)
    before = TopReadings((Reading(0.0, LIGHT + 2e-4, touched + 2e-4, 1e-4, touch, 32),))
    given = {"touch": first, "stretch": 0.0, "depth": first.height - HAND, "mounting": MOUNT, "sphere": sphere()}
    added = ran("add_reading", before, observed_top=pressed, **given).sinks["top_readings"].value
    light, press = ran("fit_deflection", added, **given).sinks["top_readings"].value.readings
    assert press.depth == pytest.approx(pressed.height - HAND)
    assert (light.asked, light.alone) == (fitted is not None, False)
    assert light.depth == pytest.approx(LIGHT, abs=3e-5 if fitted else 2e-4)


@pytest.mark.parametrize("off", [0.0, 4e-4])
def test_what_a_camera_is_off_by_where_it_sees_the_flat_membrane_is_in_the_deviation(off):
    seen = frame(DEEP)
    flat = np.array(find_contact(seen).labels == UNDEFORMED)
    shifted = replace(seen, raw=np.where(seen.raw > 0, seen.raw + round(off / 1e-5), 0).astype(np.uint16))
    node = ran("track_height", frame=shifted, contact=find_contact(shifted))
    assert flat.any()
    assert (node.sinks["height"].sd > 3e-4) == (off > 0.0)


def test_what_is_left_of_a_learned_static_error_is_in_the_deviation():
    seen = frame(DEEP)
    zero = np.zeros(seen.raw.shape, dtype=np.float32)
    learned = Pattern(zero, zero, 2e-4, 0.0, 0.0, 0.0, 0.0)
    node = ran("track_height", frame=seen, contact=find_contact(seen), pattern=learned)
    assert node.sinks["height"].sd == pytest.approx(2e-4, rel=0.1)
    assert observed(node).fixed_sd == pytest.approx(2e-4)


def test_without_a_contact_it_is_the_rise_since_the_first_frames_that_are_kept():
    rise = None
    for count in range(1, 7):
        node = ran("track_height", rise, frame=frame(LIGHT))
        rise = node.sinks["rise"].value
        assert rise.frames == count
        assert node.sinks["height"].value == pytest.approx(0.0, abs=1e-4)
    risen, again = (ran("track_height", rise, frame=frame(DEEP)).sinks["height"].value for _ in range(2))
    assert risen == pytest.approx(DEEP - LIGHT, abs=5e-4)
    assert again == risen, "what was kept is left as it was"


@pytest.mark.parametrize("seed", [3, 6])
def test_a_height_in_the_world_counts_how_well_it_is_known_where_the_membrane_hangs(seed):
    """It was 15 and 19 stated deviations off; what was observed, of which differences are taken, leaves it out."""
    with open_cell(scene="calibration_sphere", seed=seed) as cell:
        cell.do("set_stretch", stretch="30 mm")
        cell.do("approach")
        cell.do("press", depth="8 mm")
        cell.do("average_frames", count=8)
        cell.do("segment_contact")
        found = cell.do("track_height")
        off = found.height - cell.truth()["height"]
    assert abs(off) < 3 * found.height.sd < 1e-3
    assert found.observed_top.height_sd < 0.2 * found.height.sd
