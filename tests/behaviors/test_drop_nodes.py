"""The curve that readings of a top tell, which of them count, and what is planned from it."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stretch_bt.behaviors._readings import Reading, Touch, frames_at, of_one_kind, readings_of, tell_again
from stretch_bt.model import ForceModel
from stretch_bt.perception.types import CONTACT, UNDEFORMED
from stretch_bt.run.context import RunContext
from stretch_bt.tree.ports import Behavior, Role, Status
from stretch_bt.tree.registry import lookup
from stretch_bt.units import Estimate


def tracked(readings: list[tuple[float, float]], **more: Any) -> Behavior:
    """Return `track_drop` after it ran at each reading (depth of the hand, height), m, without an approach."""
    info = lookup("track_drop")
    assert info is not None
    node = info.cls("main/track_drop")
    node.context = RunContext()
    for depth, height in readings:
        look(node, depth, height, **more)
    return node


def look(node: Behavior, depth: float, height: float, **more: Any) -> None:
    """Let `track_drop` run once more."""
    given_ = {"radius": 0.03, "stretch": 0.0, "contact_height": 0.06, "contact_height_sd": 2e-5, "height_sd": 2e-5}
    inputs = {**given_, "frame_noise": 0.0, "depth": height - (0.06 - depth), "height": height, **more}
    info = lookup("track_drop")
    assert info is not None
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(inputs.get, port.name, port.default)
    for _ in node.tick():
        pass


def top_of(depth: float, stiffness: float = 600.0) -> float:
    """Return the height of a spring's top, m, under the default hand, by bisection."""
    low, high = 0.05, 0.06
    for _ in range(40):
        middle = (low + high) / 2
        force, _ = ForceModel.default().predict(0.03, 0.0, max(middle - (0.06 - depth), 0.0))
        low, high = (low, middle) if force > stiffness * (0.06 - middle) else (middle, high)
    return low


DEPTHS = [0.003, 0.005, 0.007, 0.009, 0.011, 0.013]


def test_a_drop_is_read_off_all_presses_together() -> None:
    noise = [3e-5, -6e-5, 5e-5, -2e-5, 4e-5, -8e-5]
    exact = [top_of(depth) for depth in DEPTHS]
    heights = [h + e for h, e in zip(exact, noise, strict=True)]
    node = tracked(list(zip(DEPTHS, heights, strict=True)), height_sd=5e-5, power=1.0, power_sd=0.1)
    assert node.status is Status.SUCCESS
    drop, settled = node.sinks["drop"], node.sinks["settled"]
    assert drop.sd is not None
    assert abs(drop.value - (0.06 - exact[-1])) < 2 * drop.sd < 0.2e-3
    assert abs(settled.value - exact[-1]) < abs(noise[-1]), "the curve evens out the noise of the last reading"
    force, _ = ForceModel.default().predict(0.03, 0.0, exact[-1] - (0.06 - DEPTHS[-1]))
    assert node.sinks["force"].value == pytest.approx(force, rel=0.03)
    assert -1 < node.sinks["together"].value < 0


def touch(height: float, bent: float = 1 / 0.03) -> Touch:
    """Return a first touch that shows a cap of so much curvature, 1/m, at a height above the membrane, m."""
    x, y = np.meshgrid(*[np.arange(-20, 21) * 4e-4] * 2)
    points = np.stack([x, y, height - bent * (x**2 + y**2) / 2], axis=-1)
    labels = np.where(np.hypot(x, y) < 6e-3, CONTACT, UNDEFORMED).astype(np.uint8)
    return Touch(points, np.ones(x.shape, bool), labels, 32)


def test_heights_of_touches_are_told_again_when_the_radius_is_known() -> None:
    noise, known = np.random.default_rng(3).normal(0, 3e-4, (41, 41)), Estimate(1 / 0.03, 0.5)
    context = tracked([]).context
    readings = readings_of(context)
    for height in (0.0015, 0.0025):
        seen = touch(height)
        seen.points[..., 2] += noise
        readings.append(Reading(0.0, height + 3e-4, height + 0.05, 1e-4, seen))
    tell_again(context, known, by_membrane=False)
    for reading, height in zip(readings, (0.0015, 0.0025), strict=True):
        assert reading.depth == pytest.approx(height, abs=3e-5)
        assert reading.hand == pytest.approx(0.05 - 3e-4)
    before = list(readings)
    tell_again(context, known, by_membrane=False)
    assert all(one is other for one, other in zip(readings, before, strict=True)), "once for each radius"
    tell_again(context, Estimate(1 / 0.02, 5.0), by_membrane=False)
    assert all(one.height != other.height for one, other in zip(readings, before, strict=True))


def test_a_press_that_was_left_alone_forgets_its_readings_before() -> None:
    node = tracked([(0.005, top_of(0.005))])
    top = top_of(0.012)
    look(node, 0.012, top + 4e-4)
    look(node, 0.012, top, fresh=True)
    assert [reading.height for reading in readings_of(node.context)] == pytest.approx([top_of(0.005), top])


def test_a_press_at_the_place_of_an_earlier_one_is_another() -> None:
    near, far, off = 0.009, 0.012, 8e-5  # by which the hand stands otherwise as it comes back
    node = tracked([(near, top_of(near)), (near, top_of(near)), (far, top_of(far))], frame_noise=3e-4, frames=16)
    back = {"frame_noise": 3e-4, "frames": 16, "height_sd": 1e-5}
    look(node, near, top_of(near) + off, **back, fresh=True)
    assert len(readings_of(node.context)) == 4, "what was seen before the hand went away still counts"
    assert node.sinks["crept"].value == 0.0
    assert frames_at(node.context, readings_of(node.context)[-1]) == 16
    look(node, near, top_of(near) + off + 1e-5, **back, fresh=True)
    assert len(readings_of(node.context)) == 4
    look(node, near, top_of(near) + off + 1e-5, **back)
    assert node.sinks["crept"].value == pytest.approx(0.0, abs=1e-9)


def test_a_hand_above_the_top_tells_no_drop() -> None:
    node = tracked([(d, top_of(d)) for d in (0.003, 0.009)])
    look(node, -0.001, 0.06)
    assert node.status is Status.FAILURE
    assert "not past the undeformed top" in node.reason


def test_an_approach_forgets_the_curve_of_the_object_before(scripted_device: Callable[..., Any]) -> None:
    node = tracked([(d, top_of(d)) for d in (0.003, 0.005, 0.008)])
    names = {"arm": "Arm", "camera": "DepthCamera", "gripper": "Gripper"}
    node.context.devices = {name: scripted_device(kind) for name, kind in names.items()}
    info = lookup("approach")
    assert info is not None
    approach = info.cls("main/approach")
    approach.context, approach.device_names = node.context, {name: name for name in names}
    for port in info.of(Role.INPUT):
        approach.wiring[port.name] = partial(dict.get, {}, port.name, port.default)
    approach.initialise()
    plan = follow(node, "plan_press", radius=0.03, contact_height=0.06, drop=0.0015)
    assert plan.status is Status.FAILURE
    assert "run 'track_drop' first" in plan.reason


def test_an_approach_gives_the_top_by_its_readings_alone() -> None:
    node = tracked([])
    readings = readings_of(node.context)
    readings.extend(
        Reading(0.0, top_of(d) - (0.06 - d), top_of(d), 2e-5, touch(top_of(d) - (0.06 - d))) for d in (0.002, 0.004)
    )
    look(node, 0.012, top_of(0.012), contact_height=0.07, power=1.0, power_sd=0.1)
    assert node.sinks["top"].value == pytest.approx(0.06, abs=1e-4)


def test_a_press_that_still_gives_way_says_so_and_forgets_its_older_half() -> None:
    node = tracked([(0.005, top_of(0.005))])
    top = top_of(0.012)
    for crept in (0.0, 0.0, -4e-4, -4e-4):
        look(node, 0.012, top + crept)
    crept = node.sinks["crept"]
    assert crept.value == pytest.approx(-4e-4)
    assert abs(crept.value) > 3 * crept.sd
    assert len(readings_of(node.context)) == 3, "the reading before it, and the newer half"


def test_a_press_that_holds_still_keeps_all_its_readings() -> None:
    node = tracked([(0.005, top_of(0.005))] + [(0.012, top_of(0.012))] * 4)
    assert node.sinks["crept"].value == pytest.approx(0.0, abs=1e-9)
    assert len(readings_of(node.context)) == 5


def follow(node: Behavior, name: str, **inputs: Any) -> Behavior:
    """Return a node of this name after it ran in the context of another."""
    info = lookup(name)
    assert info is not None
    after = info.cls(f"main/{name}")
    after.context = node.context
    for port in info.of(Role.INPUT):
        after.wiring[port.name] = partial(inputs.get, port.name, port.default)
    for _ in after.tick():
        pass
    return after


def test_the_planned_press_passes_the_drop_and_the_curve_gives_the_stiffness_there() -> None:
    # Under 8 mm of depth the top of this spring drops by less than 1 mm.
    node = tracked([(d, top_of(d)) for d in (0.003, 0.005, 0.008)], power=1.0, power_sd=0.1)
    plan = follow(node, "plan_press", radius=0.03, contact_height=0.06, drop=0.0015)
    assert plan.status is Status.SUCCESS, plan.reason
    depth = plan.sinks["depth"].value
    assert plan.sinks["stretch"].value == 0.0
    assert 0.0015 <= 0.06 - top_of(depth) < 0.0019
    look(node, depth, top_of(depth), power=1.0, power_sd=0.1)
    told = follow(node, "stiffness_at", drop=0.0015).sinks["stiffness"]
    assert abs(told.value - 600.0) < 2 * told.sd < 120.0


def test_no_press_within_the_limits_is_a_failure_with_its_reason() -> None:
    node = tracked([(d, top_of(d)) for d in (0.003, 0.005, 0.008)])
    plan = follow(node, "plan_press", radius=0.03, contact_height=0.06, drop=0.0015, max_depth=0.008, max_stretch=0.0)
    assert plan.status is Status.FAILURE
    assert "no press within the limits" in plan.reason


def test_where_none_is_harder_a_deflection_that_will_do_is_no_failure() -> None:
    node = tracked([(d, top_of(d)) for d in (0.003, 0.005, 0.008)])
    limits = {"radius": 0.03, "contact_height": 0.06, "drop": 0.003, "max_depth": 0.008, "max_stretch": 0.0}
    plan = follow(node, "plan_press", **limits, least=0.0002)
    assert plan.status is Status.SUCCESS, plan.reason
    assert plan.sinks["hardest"].value is True
    assert plan.sinks["depth"].value == pytest.approx(0.008)
    short = follow(node, "plan_press", **limits, least=0.0025)
    assert short.status is Status.FAILURE
    assert "of 2.50 mm" in short.reason


def test_the_next_look_presses_harder_until_the_stiffness_is_known() -> None:
    node = tracked([(d, top_of(d)) for d in (0.003, 0.005, 0.008)], power=1.0, power_sd=0.1)
    given_ = {"radius": 0.03, "contact_height": 0.06, "drop": 0.0015, "max_depth": 0.016, "max_stretch": 0.0}
    plan = follow(node, "plan_active", **given_, least_gain=0.0, wanted=0.001)
    assert plan.status is Status.SUCCESS, plan.reason
    assert plan.sinks["done"].value is False
    assert plan.sinks["stretch"].value == 0.0
    assert 0.008 < plan.sinks["depth"].value <= 0.016
    assert plan.sinks["count"].value >= 8
    assert plan.sinks["gain"].value > 0
    for known in ({"wanted": 0.9}, {"wanted": 0.001, "least_gain": 10.0}):
        ended = follow(node, "plan_active", **{"least_gain": 0.0, **given_, **known})
        assert ended.sinks["done"].value is True
        assert ended.sinks["depth"].value == pytest.approx(0.008)
        assert ended.sinks["gain"].value == 0.0


def test_frames_of_one_press_count_together() -> None:
    node = tracked(
        [(0.005, top_of(0.005)), (0.012, top_of(0.012)), (0.012, top_of(0.012))], frame_noise=3e-4, frames=16
    )
    assert frames_at(node.context, readings_of(node.context)[-1]) == 32


@pytest.mark.parametrize(
    ("alone", "kept"),
    [("--", [0, 1, 2]), ("+--", [1, 2, 3]), ("++---", [2, 3, 4, 5]), ("+-", [0, 1, 2]), ("++", [0, 1, 2]), ("", [0])],
)
def test_touches_told_by_the_contact_alone_do_not_count_beside_two_told_by_the_membrane(
    alone: str, kept: list[int]
) -> None:
    touches = [replace(touch(0.001), by_membrane=True, alone=sign == "+") for sign in alone]
    readings = [Reading(0.0, 0.001, 0.06, 3e-5, one) for one in touches] + [Reading(0.0, 0.01, 0.059, 3e-5)]
    assert of_one_kind(readings) == [readings[i] for i in kept]
