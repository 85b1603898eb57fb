"""Heights of a sphere's top by the whole membrane, where the run knows how that is mounted, and by the contact elsewhere."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from stretch_bt.behaviors._membrane import Mounting, told_by_membrane
from stretch_bt.behaviors._readings import Reading, Touch, readings_of
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import Sphere, deproject, find_contact, to_membrane
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.pressed.table import read_shapes
from stretch_bt.perception.types import UNDEFORMED
from stretch_bt.run.context import RunContext
from stretch_bt.tree.ports import Role, Status
from stretch_bt.tree.registry import lookup
from stretch_bt.units import Estimate

CAMERA, DISTANCE = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333), 0.2
RADIUS, SPAN, DEEP, LIGHT, HAND = 0.03, 0.014, 8e-3, 2.5e-3, 0.05
MOUNT = Mounting(SPAN, Estimate(6e-4, 3e-5))


def frame(depth, beside=0.0):
    """Return what a camera sees of a press by the table's shapes, with 0.05 mm of noise."""
    form = read_shapes().at(SPAN, 0.002).form(RADIUS, depth)
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    z = np.zeros(u.shape)
    for _ in range(8):  # where a ray meets the membrane
        x, y = (u - CAMERA.cx) / CAMERA.fx * (DISTANCE - z), (v - CAMERA.cy) / CAMERA.fy * (DISTANCE - z)
        lifted, hung = form.heights((x - beside).ravel(), y.ravel())
        z = (depth * lifted + MOUNT.hang.value * hung).reshape(u.shape)
    seen = DISTANCE - z + np.random.default_rng(1).normal(0, 5e-5, z.shape)
    raw = np.where((np.abs(x) < 0.04) & (np.abs(y) < 0.055), np.round(seen / 1e-5), 0).astype(np.uint16)
    return DepthFrame(raw, 1e-5, CAMERA, 0.0, 0, DISTANCE, hand_height=HAND, stretch=0.0)


def sphere(curvature=1 / RADIUS):
    nowhere = np.zeros(3)
    return Sphere(RADIUS, 0.03 * RADIUS, nowhere, nowhere, curvature, 0.03 / RADIUS)


def ran(context, name, **given):
    """Return a node after its one tick."""
    info = lookup(name)
    node = info.cls(f"main/{name}")
    node.context = context
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(given.get, port.name, port.default)
    for _ in node.tick():
        pass
    assert node.status is Status.SUCCESS, node.reason
    return node


def told(mount=MOUNT, *, fitted=None, beside=0.0):
    """Return the run and `track_height` after it looked at a deep press."""
    context, seen = RunContext(), frame(DEEP, beside)
    if mount is not None:
        context.memory[Mounting] = mount
    return context, ran(context, "track_height", frame=seen, contact=find_contact(seen), sphere=fitted)


def test_the_whole_membrane_tells_the_height_of_a_sphere():
    context, node = told(fitted=sphere())
    assert node.sinks["height"].value == pytest.approx(HAND + DEEP, abs=4e-5)
    assert told_by_membrane(context)


@pytest.mark.parametrize(
    ("mount", "fitted", "beside"),
    [(None, sphere(), 0.0), (MOUNT, None, 0.0), (MOUNT, sphere(-1 / RADIUS), 0.0), (MOUNT, sphere(), 9e-3)],
    ids=["no mount", "no sphere", "concave", "off the middle"],
)
def test_the_contact_tells_it_elsewhere(mount, fitted, beside):
    context, node = told(mount, fitted=fitted, beside=beside)
    assert node.sinks["height"].value == pytest.approx(HAND + DEEP, abs=4e-4)
    assert not told_by_membrane(context)


@pytest.mark.parametrize("fitted", [None, sphere()])
def test_first_touches_are_told_as_the_press_is_whatever_noise_is_stated(fitted):
    context, node = told(fitted=fitted)
    seen = frame(LIGHT)
    points, valid = deproject(seen)
    touch = Touch(to_membrane(points, DISTANCE), valid, find_contact(seen).labels, 32)
    touched = HAND + DEEP + 8e-4  # the top gave way by as much until the press
    readings_of(context).append(Reading(0.0, LIGHT + 2e-4, touched + 2e-4, 1e-4, touch))
    given = {"radius": RADIUS, "radius_sd": 5e-4, "stretch": 0.0, "depth": DEEP, "height": node.sinks["height"].value}
    ran(context, "track_drop", contact_height=touched + 2e-4, **given)
    first = readings_of(context)[0]
    assert first.touch.by_membrane == (fitted is not None)
    assert first.depth == pytest.approx(LIGHT, abs=3e-5 if fitted else 2e-4)


@pytest.mark.parametrize("off", [0.0, 4e-4])
def test_what_a_camera_is_off_by_where_it_sees_the_flat_membrane_is_in_the_deviation(off):
    seen = frame(DEEP)
    flat = np.array(find_contact(seen).labels == UNDEFORMED)
    shifted = replace(seen, raw=np.where(seen.raw > 0, seen.raw + round(off / 1e-5), 0).astype(np.uint16))
    node = ran(RunContext(), "track_height", frame=shifted, contact=find_contact(shifted))
    assert flat.any()
    assert (node.sinks["height"].sd > 3e-4) == (off > 0.0)


def test_what_is_left_of_a_learned_static_error_is_in_the_deviation():
    context, seen = RunContext(), frame(DEEP)
    zero = np.zeros(seen.raw.shape, dtype=np.float32)
    context.memory[Pattern] = Pattern(zero, zero, 2e-4, 0.0, 0.0, 0.0, 0.0)
    node = ran(context, "track_height", frame=seen, contact=find_contact(seen))
    assert node.sinks["height"].sd == pytest.approx(2e-4, rel=0.1)
