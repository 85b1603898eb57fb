"""Nodes that look: fresh frames only, and refusals with their reason."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stretch_bt import perception
from stretch_bt.clock import VirtualClock
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.limits import Limits
from stretch_bt.perception.types import Contact
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.build import build
from stretch_bt.tree.flow.base import why_failed
from stretch_bt.tree.ports import MISSING, Behavior, Cell, Role, Status
from stretch_bt.tree.program import load_program
from stretch_bt.tree.registry import lookup

LENS = Intrinsics(475.0, 475.0, 4.0, 3.0, 8, 6)


class Camera:
    """A camera whose latest frame a test sets."""

    def __init__(self) -> None:
        self.latest = self.reading(0, 0.0)
        self.ended = False

    def reading(self, number: int, time: float) -> Reading[DepthFrame]:
        raw = np.full((6, 8), 1600 + number, np.uint16)
        return Reading(DepthFrame(raw, 125e-6, LENS, time, number, 0.2), time, time, number)

    def show(self, number: int, time: float) -> None:
        self.latest = self.reading(number, time)

    def frame(self, max_age: float) -> Reading[DepthFrame]:
        return self.latest


def node(name: str, devices: dict[str, Any], context: RunContext | None = None, **inputs: Any) -> Behavior:
    info = lookup(name)
    assert info is not None
    made = info.cls(f"main/{name}")
    made.context = context or RunContext()
    made.context.devices = devices
    made.device_names = {p.name: p.name for p in info.of(Role.DEVICE) if p.name in devices}
    for p in info.of(Role.INPUT):
        made.wiring[p.name] = partial(inputs.get, p.name, p.default)
    return made


def tick(made: Behavior) -> Status:
    for _ in made.tick():
        pass
    status: Status = made.status
    return status


def test_capture_waits_for_a_frame_exposed_after_it_began_and_takes_each_once() -> None:
    camera = Camera()
    capture = node("capture", {"camera": camera})
    capture.context.now = 1.0
    camera.show(7, 0.98)
    assert tick(capture) is Status.RUNNING
    camera.show(8, 1.01)
    assert tick(capture) is Status.SUCCESS
    assert capture.sinks["frame"].value.sequence == 8
    capture.context.now = 1.0
    assert tick(capture) is Status.RUNNING, "frame 8 was handed out before"
    camera.show(9, 1.05)
    assert tick(capture) is Status.SUCCESS
    camera.ended = True
    assert tick(capture) is Status.FAILURE
    assert capture.reason == "the recording has ended"


def test_two_nodes_of_one_run_do_not_take_the_same_frame_and_another_run_begins_anew() -> None:
    camera, context = Camera(), RunContext()
    ends = [tick(node("capture", {"camera": camera}, given)) for given in (context, context, RunContext())]
    assert ends == [Status.SUCCESS, Status.RUNNING, Status.SUCCESS]


def test_average_frames_takes_so_many_different_ones() -> None:
    camera = Camera()
    average = node("average_frames", {"camera": camera}, count=3)
    for number in (0, 0, 1, 1):
        camera.show(number, number / 30)
        assert tick(average) is Status.RUNNING
    camera.show(2, 0.1)
    assert tick(average) is Status.SUCCESS
    mean = average.sinks["frame"].value
    assert mean.raw * mean.unit == pytest.approx(np.full((6, 8), 1601 * 125e-6), abs=mean.unit)


def contact_of(height: Callable[[np.ndarray], np.ndarray]) -> Contact:
    """Return what is seen from straight above of a membrane of a height, m, by the distance from its axis, m."""
    v, u = np.mgrid[0:120, 0:120]
    x, y = (u - 60) * 0.5e-3, (v - 60) * 0.5e-3
    away = np.hypot(x, y)
    z = height(away) + np.random.default_rng(3).normal(0, 1e-4, x.shape)
    touching, surface = away < 8e-3, np.stack([x, y, z], axis=-1).astype(np.float32)
    points = surface[touching]
    rays = np.broadcast_to(np.float32([0.0, 0.0, -1.0]), points.shape)
    labels = np.where(touching, 2, 1).astype(np.uint8)
    return Contact(points, rays, labels, 1e-4, 0.0, 0.0, 0.0, surface, touching.astype(np.float32))


def ball(away: np.ndarray) -> np.ndarray:
    """A ball of 30 mm radius that a membrane leaves at 20 degrees, as a catenoid."""
    rim, neck = 0.03 * np.sin(0.35), 0.03 * np.sin(0.35) ** 2
    inside = np.sqrt(np.maximum(0.03**2 - away**2, 0.0)) - 0.03 * np.cos(0.35)
    return np.where(away < rim, inside, -neck * (np.arccosh(np.maximum(away, rim) / neck) - np.arccosh(rim / neck)))


def flat(away: np.ndarray) -> np.ndarray:
    return np.zeros_like(away)


@pytest.mark.parametrize("height", [flat, lambda away: -ball(away)])
def test_fit_sphere_refuses_what_carries_no_convex_radius(height: Callable[[np.ndarray], np.ndarray]) -> None:
    fit = node("fit_sphere", {}, contact=contact_of(height))
    assert tick(fit) is Status.FAILURE
    assert "radius" in fit.reason or "concave" in fit.reason
    assert fit.sinks["sphere"].value is MISSING


def test_fit_sphere_writes_what_it_finds() -> None:
    fit = node("fit_sphere", {}, contact=contact_of(ball))
    assert tick(fit) is Status.SUCCESS
    sphere = fit.sinks["sphere"].value
    assert abs(sphere.radius - 0.03) < 4 * sphere.radius_sd < 0.01


def test_fit_sphere_counts_an_earlier_fit_which_stands_where_there_is_no_other() -> None:
    cap, plane = contact_of(ball), contact_of(flat)
    alone = node("fit_sphere", {}, contact=cap)
    assert tick(alone) is Status.SUCCESS
    before = alone.sinks["sphere"].value
    for contact in (cap, plane):
        fit = node("fit_sphere", {}, contact=contact, before=before)
        assert tick(fit) is Status.SUCCESS
        told = fit.sinks["sphere"].value
        assert (told is before) == (contact is plane)
        assert told.radius == pytest.approx(before.radius)
    both = node("fit_sphere", {}, contact=cap, before=before)
    tick(both)
    assert both.sinks["sphere"].value.radius_sd == pytest.approx(before.radius_sd / np.sqrt(2))


APPROACH = """\
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera, gripper: Gripper, force_sensor: ForceSensor}
trees:
  main:
    out: {touch: Touch, contact_height: Length, readings: int}
    sequence:
      - approach: INPUTS
      - set: {readings: top_readings.count}
"""


class Approach:
    """The shipped `approach`, which nothing stops but itself: no runner does."""

    def __init__(self, opened: Any, clock: VirtualClock, context: RunContext, folder: Path, inputs: str) -> None:
        (folder / "tree.yaml").write_text(APPROACH.replace("INPUTS", inputs))
        self.opened, self.clock, self.context = opened, clock, context
        self.context.devices = opened.devices
        self.built = build(load_program(folder / "tree.yaml").require(), context)
        self.root = self.built.root

    def tick(self) -> Status:
        self.context.now = self.clock.now()
        for _ in self.root.tick():
            pass
        self.clock.advance(0.05)
        status: Status = self.root.status
        return status

    def end(self) -> Status:
        status = self.tick()
        while status is Status.RUNNING and self.clock.now() < 100.0:
            status = self.tick()
        return status

    @property
    def reason(self) -> str:
        return why_failed(self.root).removeprefix("main/approach/")

    @property
    def height(self) -> float:
        height: float = self.opened.devices["arm"].pose(1.0).value.height
        return height

    def moves(self) -> float:
        """Return how far the hand goes after it has had time to brake, m."""
        self.clock.advance(0.5)
        before = self.height
        self.clock.advance(1.0)
        return abs(self.height - before)

    def output(self, name: str) -> Cell:
        return self.built.outputs[name][1]


@pytest.fixture
def approaching(cell: Callable[..., Any], virtual_clock: VirtualClock, tmp_path: Path) -> Callable[..., Approach]:
    """Place the hand a little above the object, to approach that; the hand still knows the first contact of another one, far above."""

    def place(scene: str, above: float = 0.008, lowest: float | None = None, inputs: str = "") -> Approach:
        opened = cell(scene)
        start = opened.devices["arm"].pose(1.0).value
        opened._context.twin.place(start.at_height(opened.truth()["contact_height"] + above))
        opened.hand.contact_height = 0.5
        context = RunContext(opened.hand)
        if lowest is not None:
            context.limits = Limits.model_validate({"height": {"min": f"{lowest} m", "max": "0.6 m"}})
        travel = "" if "max_travel" in inputs else "max_travel: 25 mm, "
        return Approach(opened, virtual_clock, context, tmp_path, f"{{{travel}average: 2, contact_height, {inputs}}}")

    return place


def test_approach_finds_the_undeformed_top(approaching: Callable[..., Approach]) -> None:
    approach = approaching("water_balloon")
    assert approach.end() is Status.SUCCESS, approach.reason
    found, touch = approach.output("contact_height"), approach.output("touch").value
    assert abs(found.value - approach.opened.truth()["contact_height"]) < 4 * found.read_sd() < 0.002
    assert (touch.height, touch.height_sd) == (found.value, found.sd)
    assert approach.opened.hand.contact_height == found.value, "from which the cell counts depths"
    assert approach.output("readings").value == 5
    assert approach.moves() == 0


@pytest.mark.parametrize(("inputs", "lowest"), [("", None), ("max_travel: none", 0.095), ("max_travel: 500 mm", 0.095)])
def test_approach_gives_up_where_nothing_is(
    approaching: Callable[..., Approach], inputs: str, lowest: float | None
) -> None:
    """At the end of its travel, or where the cell ends before that."""
    approach = approaching("water_balloon", above=0.060, lowest=lowest, inputs=inputs)
    assert (approach.end(), approach.reason) == (Status.FAILURE, "descend: nothing was met down to 95 mm")
    assert approach.opened.hand.contact_height is None
    assert approach.moves() == 0
    assert approach.height == pytest.approx(0.095)


@pytest.mark.parametrize(
    "scene", ["water_balloon", "wooden_cube", pytest.param("wire_circle", marks=pytest.mark.slow), "calibration_cone"]
)
def test_approach_refuses_to_begin_in_contact(approaching: Callable[..., Approach], scene: str) -> None:
    """The pressed membrane would be taken for the free one, and the object for nothing."""
    approach = approaching(scene, above=-0.004)
    height = approach.height
    assert approach.end() is Status.FAILURE
    assert "touches something already" in approach.reason
    assert "raise the hand" in approach.reason
    assert (approach.moves(), approach.height) == (0, height)


def test_approach_stops_at_too_much_force(approaching: Callable[..., Approach]) -> None:
    approach = approaching("calibration_sphere", inputs="max_force: 0.05 N")
    assert approach.end() is Status.FAILURE
    assert "N exceeds the limit of 0.05 N" in approach.reason
    assert approach.moves() == 0


def test_approach_finds_out_a_false_alarm(
    approaching: Callable[..., Approach], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(perception.ContactDetector, "update", lambda self, frame: True)
    approach = approaching("water_balloon", above=0.060, inputs="readings: 2")
    assert approach.end() is Status.FAILURE
    assert approach.reason == "until_the_top_shows: the condition still does not hold after 4 passes"
    assert approach.output("touch").value is MISSING
    assert approach.opened.hand.contact_height is None
    assert approach.moves() == 0


def test_approach_interrupted_stops_the_arm(approaching: Callable[..., Approach]) -> None:
    approach = approaching("water_balloon")
    while (
        approach.tick() is Status.RUNNING and approach.built.nodes["main/approach/descend"].status is not Status.RUNNING
    ):
        pass
    assert approach.moves() > 0
    approach.root.stop(Status.INVALID)
    assert approach.moves() == 0


def contact_at(points: np.ndarray) -> Contact:
    rays = points - [0.0, 0.0, 0.2]
    labels, sure = np.full((2, 2), 2, np.uint8), np.ones((2, 2))
    away = np.linalg.norm(rays, axis=1)[:, None]
    return Contact(points, rays / away, labels, 2e-4, 0.1, 0.0, 0.0, np.zeros((2, 2, 3)), sure)


def test_fit_shape_writes_the_shape_and_how_all_compare() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-0.01, 0.01, (2, 600))
    z = np.sqrt(0.03**2 - x**2 - y**2) - 0.02 + rng.normal(0, 1e-4, 600)
    for wanted, kind in (("auto", "sphere"), ("sphere", "sphere")):
        fit = node("fit_shape", {"shape": wanted}, contact=contact_at(np.column_stack((x, y, z))))
        assert tick(fit) is Status.SUCCESS
        fitted = fit.sinks["shape_fit"].value
        assert fitted.kind == kind
        assert fitted.radius == pytest.approx(0.03, rel=0.05)
    fit = node("fit_shape", {"shape": "plane"}, contact=contact_at(np.column_stack((x, x, z))))
    assert tick(fit) is Status.FAILURE
    assert "one line" in fit.reason
