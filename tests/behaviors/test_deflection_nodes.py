"""The curve that readings of a top give, which of them count, and what is planned from it."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stretch_bt.behaviors._readings import FirstTouch, Reading, frames_at, infer_again, of_one_kind
from stretch_bt.behaviors.records import Candidates, ObservedTop, PlannedPress, TopReadings, Touch
from stretch_bt.model import ForceModel
from stretch_bt.perception import Sphere
from stretch_bt.perception.types import CONTACT, UNDEFORMED
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.ports import Behavior, Role, Status
from stretch_bt.tree.registry import lookup
from stretch_bt.units import Estimate

TOUCH = Touch(0.06, 2e-5)
SPHERE = Sphere(0.03, 0.0, np.zeros(3), np.zeros(3), 1 / 0.03, 0.0)
HAND = RunContext().hand.geometry
OWN_POWER: dict[str, Any] = {"power": 1.0, "power_sd": 0.1}  # of a spring, whose top the tests compute


def ran(name: str, before: TopReadings | None = None, **given: Any) -> Behavior:
    """Return a node after its one tick, with the readings that were there before."""
    info = lookup(name)
    assert info is not None
    node = info.cls(f"main/{name}")
    node.context = RunContext()
    inputs = {"touch": TOUCH, "sphere": SPHERE, "stretch": 0.0, **given}
    for port in info.of(Role.INPUT):
        node.wiring[port.name] = partial(inputs.get, port.name, port.default)
    if "top_readings" in node.sinks:
        node.sinks["top_readings"].value = before
    for _ in node.tick():
        pass
    return node


def look(before: TopReadings | None, depth: float, height: float, *, height_sd: float = 2e-5, **more: Any) -> Behavior:
    """Return `fit_deflection` after one more reading: the height, m, of the top under a hand so deep."""
    seen = ObservedTop(height, height_sd, 0.0, by_membrane=False)
    added = ran("add_reading", before, observed_top=seen, depth=depth, **more)
    assert added.status is Status.SUCCESS, added.reason
    return ran("fit_deflection", kept(added), **more)


def kept(node: Behavior) -> TopReadings:
    """Return the readings that a node leaves."""
    readings: TopReadings = node.sinks["top_readings"].value
    return readings


def tracked(presses: list[tuple[float, float]], **more: Any) -> Behavior:
    """Return `fit_deflection` after a reading at each press (depth of the hand, height), m, without first touches."""
    before = None
    for depth, height in presses:
        node = look(before, depth, height, **more)
        before = kept(node)
    return node


def heights(node: Behavior) -> list[float]:
    return [reading.height for reading in kept(node).readings]


def top_of(depth: float, stiffness: float = 600.0) -> float:
    """Return the height of a spring's top, m, under the default hand, by bisection."""
    low, high = 0.05, 0.06
    for _ in range(40):
        middle = (low + high) / 2
        force, _ = ForceModel.default().predict(0.03, 0.0, max(middle - (0.06 - depth), 0.0))
        low, high = (low, middle) if force > stiffness * (0.06 - middle) else (middle, high)
    return low


DEPTHS = [0.003, 0.005, 0.007, 0.009, 0.011, 0.013]


def test_a_deflection_is_read_off_all_presses_together() -> None:
    noise = [3e-5, -6e-5, 5e-5, -2e-5, 4e-5, -8e-5]
    exact = [top_of(depth) for depth in DEPTHS]
    seen = [h + e for h, e in zip(exact, noise, strict=True)]
    node = tracked(list(zip(DEPTHS, seen, strict=True)), height_sd=5e-5, **OWN_POWER)
    assert node.status is Status.SUCCESS
    felt = node.sinks["felt"].value
    assert abs(felt.deflection - (0.06 - exact[-1])) < 2 * felt.deflection_sd < 0.2e-3
    assert abs(felt.height - exact[-1]) < abs(noise[-1]), "the curve evens out the noise of the last reading"
    force, _ = ForceModel.default().predict(0.03, 0.0, exact[-1] - (0.06 - DEPTHS[-1]))
    assert felt.force == pytest.approx(force, rel=0.03)
    assert -1 < felt.correlation < 0


def touch(height: float, bent: float = 1 / 0.03) -> FirstTouch:
    """Return a first touch that shows a cap of so much curvature, 1/m, at a height above the membrane, m."""
    x, y = np.meshgrid(*[np.arange(-20, 21) * 4e-4] * 2)
    points = np.stack([x, y, height - bent * (x**2 + y**2) / 2], axis=-1)
    labels = np.where(np.hypot(x, y) < 6e-3, CONTACT, UNDEFORMED).astype(np.uint8)
    return FirstTouch(points, np.ones(x.shape, bool), labels)


def test_heights_of_touches_are_inferred_again_when_the_radius_is_known() -> None:
    noise, known = np.random.default_rng(3).normal(0, 3e-4, (41, 41)), Estimate(1 / 0.03, 0.5)
    readings = []
    for height in (0.0015, 0.0025):
        seen = touch(height)
        seen.points[..., 2] += noise
        readings.append(Reading(0.0, height + 3e-4, height + 0.05, 1e-4, seen, 32))
    first = infer_again(readings, known, HAND, None, by_membrane=False)
    for reading, height in zip(first, (0.0015, 0.0025), strict=True):
        assert reading.depth == pytest.approx(height, abs=3e-5)
        assert reading.hand == pytest.approx(0.05 - 3e-4)
    again = infer_again(first, known, HAND, None, by_membrane=False)
    assert all(one is other for one, other in zip(again, first, strict=True)), "once for each radius"
    other = infer_again(first, Estimate(1 / 0.02, 5.0), HAND, None, by_membrane=False)
    assert all(one.height != before.height for one, before in zip(other, first, strict=True))


def test_a_press_that_was_left_alone_forgets_its_readings_before() -> None:
    top = top_of(0.012)
    node = tracked([(0.005, top_of(0.005)), (0.012, top + 4e-4)])
    assert heights(look(kept(node), 0.012, top, rested=True)) == pytest.approx([top_of(0.005), top])


def test_a_press_at_the_place_of_an_earlier_one_is_another() -> None:
    near, far, off = 0.009, 0.012, 8e-5  # m; `off` is the change of the hand's height as it comes back
    node = tracked([(near, top_of(near)), (near, top_of(near)), (far, top_of(far))], frame_noise=3e-4, frames=16)
    back: dict[str, Any] = {"frame_noise": 3e-4, "frames": 16, "height_sd": 1e-5}
    node = look(kept(node), near, top_of(near) + off, **back, rested=True)
    assert kept(node).count == 4, "what was seen before the hand went away still counts"
    assert node.sinks["felt"].value.creep == 0.0
    assert frames_at(kept(node).readings, node.sinks["felt"].value.last) == 16
    node = look(kept(node), near, top_of(near) + off + 1e-5, **back, rested=True)
    assert kept(node).count == 4
    node = look(kept(node), near, top_of(near) + off + 1e-5, **back)
    assert node.sinks["felt"].value.creep == pytest.approx(0.0, abs=1e-9)


def test_a_hand_above_the_top_gives_no_deflection() -> None:
    node = tracked([(d, top_of(d)) for d in (0.003, 0.009)])
    above = look(kept(node), -0.001, 0.06)
    assert above.status is Status.FAILURE
    assert "not past the undeformed top" in above.reason


def test_without_a_reading_there_is_nothing_to_fit() -> None:
    node = ran("fit_deflection", TopReadings())
    assert node.status is Status.FAILURE
    assert "run 'add_reading' first" in node.reason


@pytest.mark.parametrize("radius", [1e-4, 5.0])
def test_a_sphere_that_no_hand_can_feel_is_refused(radius: float) -> None:
    node = tracked([(0.005, top_of(0.005))], sphere=replace(SPHERE, radius=radius))
    assert node.status is Status.FAILURE
    assert "no object that the hand can feel" in node.reason


def test_first_touches_give_the_top_whatever_first_contact_says() -> None:
    touches = [
        Reading(0.0, top_of(d) - (0.06 - d), top_of(d), 2e-5, touch(top_of(d) - (0.06 - d))) for d in (0.002, 0.004)
    ]
    off = replace(TOUCH, height=0.07)
    node = look(TopReadings(tuple(touches)), 0.012 + 0.01, top_of(0.012), touch=off, **OWN_POWER)
    assert node.sinks["felt"].value.top == pytest.approx(0.06, abs=1e-4)


def test_a_press_that_still_gives_way_says_so_and_forgets_its_older_half() -> None:
    top = top_of(0.012)
    node = tracked([(0.005, top_of(0.005)), *((0.012, top + crept) for crept in (0.0, 0.0, -4e-4, -4e-4))])
    felt = node.sinks["felt"].value
    assert felt.creep == pytest.approx(-4e-4)
    assert abs(felt.creep) > 3 * felt.creep_sd
    assert heights(node) == pytest.approx([top_of(0.005), top - 4e-4, top - 4e-4]), "the one before, and the newer half"


def test_a_press_that_holds_still_keeps_all_its_readings() -> None:
    node = tracked([(0.005, top_of(0.005))] + [(0.012, top_of(0.012))] * 4)
    assert node.sinks["felt"].value.creep == pytest.approx(0.0, abs=1e-9)
    assert kept(node).count == 5


@pytest.mark.parametrize("off", [(0.0, 6e-5), (0.0, 6e-5, 0.0, 1.2e-4), (1e-4, -1e-4, -1e-4, 1e-4, 0.0, -1e-4)])
def test_a_press_whose_readings_scatter_more_than_they_say_does_not_creep(off: tuple[float, ...]) -> None:
    node = tracked([(0.005, top_of(0.005)), *((0.012, top_of(0.012) + o) for o in off)])
    felt = node.sinks["felt"].value
    assert abs(felt.creep) <= 3 * felt.creep_sd
    assert kept(node).count == 1 + len(off)


def listed(node: Behavior, **limits: Any) -> Candidates:
    """Return the presses within limits."""
    candidates: Candidates = ran("list_presses", felt=node.sinks["felt"].value, **limits).sinks["candidates"].value
    return candidates


def plan(name: str, node: Behavior, limits: dict[str, Any] | None = None, **inputs: Any) -> Behavior:
    """Return a node that plans, after it ran on the object that another one felt."""
    given_ = {"candidates": listed(node, **limits or {}), "felt": node.sinks["felt"].value, "deflection": 0.0015}
    return ran(name, **{**given_, "top_readings": kept(node), **inputs})


def next_of(planned: Behavior) -> PlannedPress:
    found: PlannedPress = planned.sinks["next"].value
    return found


SHALLOW = [
    (d, top_of(d)) for d in (0.003, 0.005, 0.008)
]  # under 8 mm the top of this spring deflects by less than 1 mm


def test_the_presses_that_may_come_next_are_listed_up_to_the_largest_stretch() -> None:
    found = listed(tracked(SHALLOW), max_depth=0.012, max_force=3.0, max_stretch=0.025, stretch_step=0.01)
    assert (found.count, found.radius, found.touched_at) == (3, 0.03, 0.06), "0, 10 and 20 mm"
    assert found.limits.lowest == pytest.approx(0.048)
    assert found.limits.force == 3.0


def test_the_planned_press_passes_the_deflection_and_the_curve_gives_the_stiffness_there() -> None:
    node = tracked(SHALLOW, **OWN_POWER)
    planned = plan("plan_press", node)
    assert planned.status is Status.SUCCESS, planned.reason
    depth = next_of(planned).depth
    assert (next_of(planned).stretch, next_of(planned).known) == (0.0, False)
    assert 0.0015 <= 0.06 - top_of(depth) < 0.0019
    node = look(kept(node), depth, top_of(depth), **OWN_POWER)
    found = ran("stiffness_at", felt=node.sinks["felt"].value, deflection=0.0015).sinks["stiffness"]
    assert found.sd is not None
    assert abs(found.value - 600.0) < 2 * found.sd < 120.0


SHORT = {"max_depth": 0.008, "max_stretch": 0.0}


def test_no_press_within_the_limits_is_a_failure_with_its_reason() -> None:
    planned = plan("plan_press", tracked(SHALLOW), SHORT)
    assert planned.status is Status.FAILURE
    assert "no press within the limits" in planned.reason


def test_where_none_is_harder_a_deflection_that_will_do_is_no_failure() -> None:
    node = tracked(SHALLOW)
    enough = plan("plan_press", node, SHORT, deflection=0.003, least=0.0002)
    assert enough.status is Status.SUCCESS, enough.reason
    assert enough.sinks["hardest"].value is True
    assert next_of(enough).known
    assert next_of(enough).depth == pytest.approx(0.008)
    short = plan("plan_press", node, SHORT, deflection=0.003, least=0.0025)
    assert short.status is Status.FAILURE
    assert "of 2.50 mm" in short.reason


def test_the_next_look_presses_harder_until_the_stiffness_is_known() -> None:
    node, limits = tracked(SHALLOW, **OWN_POWER), {"max_depth": 0.016, "max_stretch": 0.0}
    planned = plan("plan_look", node, limits, least_gain=0.0, wanted_error=0.001)
    assert planned.status is Status.SUCCESS, planned.reason
    found = next_of(planned)
    assert (found.known, found.stretch) == (False, 0.0)
    assert 0.008 < found.depth <= 0.016
    assert found.frames >= 8
    assert found.gain > 0
    for known in ({"wanted_error": 0.9, "least_gain": 0.0}, {"wanted_error": 0.001, "least_gain": 10.0}):
        ended = next_of(plan("plan_look", node, limits, **known))
        assert (ended.known, ended.gain) == (True, 0.0)
        assert ended.depth == pytest.approx(0.008)


def test_a_stiffness_is_not_read_off_where_the_object_gave_way_by_too_little() -> None:
    hard = tracked([(depth, 0.06) for depth in (0.003, 0.005, 0.008)])
    found = ran("stiffness_at", felt=hard.sinks["felt"].value)
    assert found.status is Status.FAILURE
    assert "too little" in found.reason


def test_frames_of_one_press_count_together() -> None:
    node = tracked(
        [(0.005, top_of(0.005)), (0.012, top_of(0.012)), (0.012, top_of(0.012))], frame_noise=3e-4, frames=16
    )
    assert frames_at(kept(node).readings, kept(node).readings[-1]) == 32


@pytest.mark.parametrize(
    ("alone", "left"),
    [("--", [0, 1, 2]), ("+--", [1, 2, 3]), ("++---", [2, 3, 4, 5]), ("+-", [0, 1, 2]), ("++", [0, 1, 2]), ("", [0])],
)
def test_touches_given_by_the_contact_alone_do_not_count_beside_two_given_by_the_membrane(
    alone: str, left: list[int]
) -> None:
    seen = touch(0.001)
    readings = [Reading(0.0, 0.001, 0.06, 3e-5, seen, asked=True, by_membrane=sign == "-") for sign in alone]
    readings.append(Reading(0.0, 0.01, 0.059, 3e-5))
    assert of_one_kind(readings) == [readings[i] for i in left]


def test_what_settled_no_longer_counts_and_is_refused_until_the_hand_presses_harder() -> None:
    first = [(depth, top_of(depth)) for depth in DEPTHS]
    node = tracked(first, **OWN_POWER)
    again = look(kept(node), 0.008, top_of(0.008) - 5e-4, **OWN_POWER)
    assert again.status is Status.FAILURE
    assert "did not come back as it went" in again.reason
    assert "press with more than" in again.reason
    harder = look(kept(again), 0.015, top_of(0.015), **OWN_POWER)
    assert harder.status is Status.SUCCESS
    assert heights(harder) == [height for _, height in [*first, (0.015, top_of(0.015))]]
    assert harder.sinks["felt"].value.deflection == pytest.approx(0.06 - top_of(0.015), abs=5e-5)


def test_an_object_that_comes_back_is_read_again_at_less_force() -> None:
    node = tracked([(depth, top_of(depth)) for depth in DEPTHS], **OWN_POWER)
    again = look(kept(node), 0.008, top_of(0.008), **OWN_POWER)
    assert again.status is Status.SUCCESS
    assert kept(again).count == len(DEPTHS) + 1


def test_heights_of_two_kinds_are_not_held_against_each_other() -> None:
    node = tracked([(depth, top_of(depth)) for depth in DEPTHS], **OWN_POWER)
    whole = TopReadings(tuple(replace(r, asked=True, by_membrane=True) for r in kept(node).readings))
    again = look(whole, 0.008, top_of(0.008) - 5e-4, **OWN_POWER)
    assert again.status is Status.SUCCESS, again.reason
