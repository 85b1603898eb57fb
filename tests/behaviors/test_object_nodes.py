"""Nodes that measure objects: outline, cloud and dimensions, alone and in a tree."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stretch_bt.frames import Pose
from stretch_bt.perception import Cloud
from stretch_bt.perception.types import Contact
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.ports import MISSING, Behavior, Cell, Role, Status
from stretch_bt.tree.registry import lookup


def node(name: str, **inputs: Any) -> Behavior:
    info = lookup(name)
    assert info is not None
    made = info.cls(f"main/{name}")
    made.context = RunContext()
    for p in info.of(Role.INPUT):
        made.wiring[p.name] = partial(inputs.get, p.name, p.default)
    return made


def tick(made: Behavior) -> Status:
    for _ in made.tick():
        pass
    status: Status = made.status
    return status


def disc(radius: float, x: float = 0.0, cut: bool = False) -> Contact:
    """A flat, round contact in an image of 0.4 mm a pixel, seen by a hand at x."""
    v, u = np.mgrid[:80, :80]
    middle = 4.0 if cut else 40.0
    surface = np.stack([(u - middle) * 0.4e-3, (v - 40.0) * 0.4e-3, np.full(u.shape, 0.01)], axis=2)
    labels = np.where(np.hypot(surface[..., 0], surface[..., 1]) < radius, 2, 0).astype(np.uint8)
    points = surface[labels == 2]
    rays = points - [0.0, 0.0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return Contact(points, rays, labels, 1e-4, 0.05, 0.0, 0.0, surface, np.ones(labels.shape), Pose((x, 0.0, 0.05)))


def pressed(radius: float, stretch: float | None = 0.02) -> Contact:
    """A flat, round face under a membrane that falls off around it as one that is pulled alike does, in an image of 0.4 mm a pixel."""
    v, u = np.mgrid[:200, :200]
    away = np.hypot((u - 100) * 0.4e-3, (v - 100) * 0.4e-3)
    heights = 0.01 * np.clip(np.log(0.038 / np.maximum(away, radius)) / np.log(0.038 / radius), 0.0, 1.0)
    return Contact.from_heights(heights, 0.4e-3, noise=1e-5, labels=away < radius, stretch=stretch)


def test_measure_outline_writes_what_it_measures_with_deviations() -> None:
    measure = node("measure_outline", contact=pressed(0.01))
    assert tick(measure) is Status.SUCCESS, measure.reason
    circularity, area, perimeter = (measure.sinks[name] for name in ("circularity", "area", "perimeter"))
    assert circularity.value == pytest.approx(1.0, abs=0.01)
    assert abs(area.value - np.pi * 1e-4) < 2 * area.sd
    assert abs(perimeter.value - np.pi * 0.02) < 2 * perimeter.sd
    assert 0.2e-3 < area.sd / perimeter.value < 1e-3  # of the border's place; its roughness alone says 0.01 mm
    assert 0 < circularity.sd < 0.1
    by_chain = node("measure_outline", contact=pressed(0.01), method="pixel_chain")
    assert tick(by_chain) is Status.SUCCESS
    assert by_chain.sinks["circularity"].value < 0.92


def test_measure_outline_refuses_a_cut_contact() -> None:
    measure = node("measure_outline", contact=disc(0.01, cut=True))
    assert tick(measure) is Status.FAILURE
    assert "edge of the image" in measure.reason
    assert measure.sinks["circularity"].value is MISSING


def test_measure_outline_states_a_border_that_curvature_does_not_show() -> None:
    pulled, free = (node("measure_outline", contact=pressed(0.01, stretch=stretch)) for stretch in (0.02, 0.0))
    for measure in (pulled, free):
        assert tick(measure) is Status.SUCCESS, measure.reason
    assert free.sinks["area"].sd > 5 * pulled.sinks["area"].sd
    assert 0.05 < free.sinks["circularity"].sd < 0.6


def test_nodes_that_write_to_one_key_add_to_one_cloud_until_reset() -> None:
    key = Cell("cloud")
    sizes = []
    for x, reset in ((0.0, False), (0.03, False), (0.03, False), (0.0, True)):
        fuse = node("fuse_contact", contact=disc(0.01, x), reset=reset)
        fuse.sinks["cloud"] = key
        assert tick(fuse) is Status.SUCCESS
        cloud: Cloud = key.value
        sizes.append((np.ptp(cloud.points[:, 0]) > 0.04, cloud.contacts, int(cloud.seen.max())))
    assert sizes == [(False, 1, 1), (True, 2, 1), (True, 3, 2), (False, 1, 1)]


def test_measure_object_writes_lengths_or_refuses() -> None:
    fuse = node("fuse_contact", contact=disc(0.01))
    assert tick(fuse) is Status.SUCCESS
    measure = node("measure_object", cloud=fuse.sinks["cloud"].value)
    assert tick(measure) is Status.SUCCESS
    assert measure.sinks["dimensions"].value.how == ("extent", "extent", "table")
    assert measure.sinks["height"].value == pytest.approx(0.06, abs=1e-4)
    length = measure.sinks["length"]
    assert abs(length.value - 0.02) < 3 * length.sd
    assert 0 < length.sd < 2e-3
    small = node("fuse_contact", contact=disc(0.0006))
    assert tick(small) is Status.FAILURE
    assert "too small" in small.reason


def block(x: float) -> Contact:
    """A contact with a block 30 mm by 24 mm, 40 mm high, by a hand at x, 10 mm deep: flat, then falling with a slope of 0.5."""
    v, u = np.mgrid[-110:111, -105:106] * 0.42e-3
    away = np.maximum(np.abs(x + u) - 0.0143, np.abs(v) - 0.0113)
    z = np.maximum(0.010 - 0.5 * np.maximum(away, 0.0), 0.0)
    z += 1e-5 * np.random.default_rng(0).normal(size=z.shape)
    surface = np.stack([u, v, z], axis=2)
    labels = np.where(z > 0.009, 2, 1).astype(np.uint8)
    points = surface[labels == 2]
    rays = points - [0.0, 0.0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return Contact(points, rays, labels, 1e-5, 0.03, 0.0, 0.0, surface, np.ones(z.shape), Pose((x, 0.0, 0.03)))


def test_contacts_are_kept_and_their_shape_is_fitted() -> None:
    cloud, contacts = Cell("cloud"), Cell("contacts")
    for x in (0.0, 0.01):
        for name, key in (("fuse_contact", cloud), ("keep_contact", contacts)):
            made = node(name, contact=block(x))
            made.sinks[name.replace("fuse_contact", "cloud").replace("keep_contact", "contacts")] = key
            assert tick(made) is Status.SUCCESS
    assert len(contacts.value) == 2
    fit = node("fit_object", cloud=cloud.value, contacts=contacts.value, fillet_sd=0.2e-3)
    assert tick(fit) is Status.SUCCESS, fit.reason
    solid = fit.sinks["solid"].value
    assert solid.kind == "block"
    for name, value in (("length", 0.030), ("width", 0.024), ("height", 0.040)):
        found, sd = getattr(solid, name), getattr(solid, f"{name}_sd")
        assert abs(found - value) < 3 * sd < 2e-3
    assert (solid.radius, solid.radius_sd) == (None, None)
    assert len(fit.sinks["filled_cloud"].value) == len(cloud.value), "a block has no inside that hangs"
    wrong = node("fit_object", cloud=cloud.value, contacts=[])
    assert tick(wrong) is Status.FAILURE
    assert "no contact" in wrong.reason


def test_kept_contacts_begin_anew_and_are_bounded() -> None:
    key = Cell("contacts")
    for x, reset, most, count in ((0.0, False, 9, 1), (0.01, False, 9, 2), (0.02, False, 2, 2), (0.0, True, 9, 1)):
        keep = node("keep_contact", contact=disc(0.01, x), reset=reset, most=most)
        keep.sinks["contacts"] = key
        assert tick(keep) is Status.SUCCESS
        assert len(key.value) == count
        assert key.value[-1].pose.position[0] == x
    nowhere = node("keep_contact", contact=replace(disc(0.01), pose=None))
    assert tick(nowhere) is Status.FAILURE
    assert "pose" in nowhere.reason


TREE = """\
format: stretch-tree/1
doc: Press a flat cylinder at two places and measure it.
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
scene: calibration_cylinder
trees:
  feel:
    in: {depth: Length, touch: }
    inout: [cloud]
    out: [contact]
    sequence:
      - press: {depth: $depth}
      - average_frames: {count: 4}
      - segment_contact
      - fuse_contact
  main:
    out: [circularity, height, contacts, disagreement]
    sequence:
      - approach
      - feel: {depth: 6 mm}
      - feel: {depth: 8 mm}
      - measure_outline: {circularity}
      - measure_object: {height}
      - set: {contacts: cloud.contacts, disagreement: cloud.disagreement}
"""


def test_a_tree_measures_the_cylinder_of_a_scene(run: Callable[..., Any]) -> None:
    result = run(TREE)
    assert result.status == "SUCCESS", result.reason
    values = {name: output["value"] for name, output in result.to_json()["outputs"].items()}
    assert values["height"] == pytest.approx(60.0, abs=1.5)  # mm; the camera's static error is 0.5 mm
    assert values["contacts"] == 2
