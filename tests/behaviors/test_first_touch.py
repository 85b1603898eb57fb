"""The steps of `approach` on scripted devices: what each takes for a touch, and when it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.behaviors._readings import FirstTouch, Reading
from stretch_bt.behaviors.records import FreeMembrane, Mounting, TopReadings, Touch
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.model import POWER, drop_power
from stretch_bt.perception.detect import ContactDetector
from stretch_bt.perception.pattern import FreeView, Pattern
from stretch_bt.perception.types import CONTACT, UNDEFORMED
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import MISSING, Status
from stretch_bt.units import Estimate

CAMERA, DISTANCE = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333), 0.2
RADIUS, CAP, HAND = 0.03, 0.006, 0.1  # m, of a sphere, of the part of it in contact, and height of the hand
MOVING, DONE = MotionState.MOVING, MotionState.DONE
V, U = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
AWAY = np.hypot(U - CAMERA.cx, V - CAMERA.cy) * DISTANCE / CAMERA.fx


def frame(top, seed=0):
    """Return what a camera sees of a sphere whose top stands so deep, m, in the membrane, with 0.05 mm of noise."""
    near = np.minimum(AWAY, CAP)
    heights = np.clip(top - near**2 / (2 * RADIUS) - CAP / RADIUS * (AWAY - near), 0.0, None)
    noise = np.random.default_rng(seed).normal(0, 5e-5, heights.shape)
    raw = np.round((DISTANCE - heights + noise) / 1e-5).astype(np.uint16)
    return DepthFrame(raw, 1e-5, CAMERA, seed / 30, seed, DISTANCE, hand_height=HAND, stretch=0.0)


def frames(*tops):
    return [frame(top, seed) for seed, top in enumerate(tops)]


FREE = frames(*[0.0] * 12)


@pytest.fixture
def above(bench):
    """Return a run with the hand above an object, whose camera shows the given frames."""

    def make(seen=FREE, motion=(MOVING, DONE), force=0.1, limits=None):
        made = bench(camera=ScriptedDevice("DepthCamera", {"frame": list(seen)}))
        script = {"pose": Pose((0.0, 0.0, HAND)), "wrench": Wrench((0.0, 0.0, force))}
        made.context.devices["arm"] = ScriptedDevice("Arm", script, list(motion))
        made.context.limits = limits
        return made

    return make


def commands(made):
    return made.context.devices["arm"].commands


def target(made):
    """Return how high the arm was sent first."""
    return commands(made)[0].arguments["target"].height


def ran(made, name, kept=None, **inputs):
    """Return a node after it ended, where what it writes over was there before."""
    node = made.node(name, **inputs)
    for port, record in (kept or {}).items():
        node.sinks[port].value = record
    while made.tick(node) is Status.RUNNING:
        assert made.context.now < 50.0
    return node


def seen_free(shots=FREE):
    """Return what frames of the free membrane show."""
    view, detector = FreeView(), ContactDetector(false_alarms=1e-6)
    for shot in shots:
        view.add(shot)
        detector.update(shot)
    view.settle()
    return FreeMembrane(len(FREE), "camera", view, detector)


@pytest.mark.parametrize("top", [0.0, 0.001])
def test_the_free_membrane_is_looked_at_before_the_hand_moves(above, top):
    made = above(frames(*[top] * 12))
    found = ran(made, "watch_free_membrane").sinks["free_membrane"].value
    assert (found.frames, found.camera, found.view.count, found.detector.ready) == (12, "camera", 12, True)
    assert not commands(made)


def test_a_membrane_that_touches_something_at_the_begin_is_refused(above):
    node = ran(above(frames(*[0.004] * 12)), "watch_free_membrane")
    assert node.status is Status.FAILURE
    assert "touches something already" in node.reason
    assert "raise the hand" in node.reason


def test_the_hand_stops_where_it_touches_and_its_frames_are_added(above):
    made, free = above(frames(0.0, 0.0, 0.0, *[0.003] * 20), motion=[MOVING]), seen_free()
    node = ran(made, "descend", {"free_membrane": free})
    assert node.status is Status.SUCCESS, node.reason
    assert [c.name for c in commands(made)] == ["move", "stop"]
    found = node.sinks["free_membrane"].value
    assert 17 <= found.frames < 25, "after two frames in a row that show contact"
    assert (free.frames, free.view.count, free.detector.in_contact) == (12, 12, False), "what was there is left"


def test_contact_in_one_frame_alone_does_not_stop_it(above):
    made = above(frames(0.0, 0.0, 0.003, *[0.0] * 20), motion=[*[MOVING] * 15, DONE])
    node = ran(made, "descend", {"free_membrane": seen_free()})
    assert (node.status, node.reason) == (Status.FAILURE, "nothing was met down to 0 mm")


@pytest.mark.parametrize(
    ("travel", "limits", "lowest"),
    [
        (None, None, 0.0),
        (0.03, None, 0.07),
        (0.03, Limits(height={"min": "80 mm", "max": "500 mm"}), 0.08),
        (None, Limits(height={"min": "80 mm", "max": "500 mm"}), 0.08),
        (None, Limits(height={"min": "120 mm", "max": "500 mm"}), HAND),
    ],
    ids=["to the ground", "its travel", "the cell before its travel", "the cell", "never up"],
)
def test_it_gives_up_where_nothing_was_met(above, travel, limits, lowest):
    made = above(FREE, limits=limits)
    node = ran(made, "descend", {"free_membrane": seen_free()}, max_travel=travel)
    assert target(made) == pytest.approx(lowest)
    assert (node.status, node.reason) == (Status.FAILURE, f"nothing was met down to {lowest * 1e3:.0f} mm")


@pytest.mark.parametrize(("name", "kept"), [("descend", True), ("lower", False)])
def test_too_much_force_stops_it(above, name, kept):
    made = above(FREE, motion=[MOVING], force=6.0)
    node = ran(made, name, {"free_membrane": seen_free()} if kept else None, max_force=5.0)
    assert node.status is Status.FAILURE
    assert "6.00 N exceeds the limit of 5 N" in node.reason


def test_on_the_way_to_an_object_no_depth_below_the_one_before_counts(above):
    made = above(FREE)
    made.context.hand.contact_height = 0.09
    ran(made, "descend", {"free_membrane": seen_free()})
    assert made.context.hand.contact_height is None


def test_the_hand_is_lowered_by_a_step_wherever_first_contact_is(above):
    made = above()
    assert ran(made, "lower", by=0.002).status is Status.SUCCESS
    assert target(made) == pytest.approx(HAND - 0.002)


@pytest.mark.parametrize(("top", "rise"), [(0.0, None), (0.002, None), (0.0045, 0.002)])
def test_contact_that_was_noticed_late_raises_the_hand_to_a_light_touch(above, top, rise):
    made = above()
    assert ran(made, "rise_to_touch", frame=frame(top)).status is Status.SUCCESS
    if rise is None:
        assert not commands(made)
    else:
        assert target(made) == pytest.approx(HAND + rise, abs=3e-4)


def through(error):
    """Return what a camera of a static error, m, sees of the free membrane."""
    return [replace(shot, raw=(shot.raw + np.round(error / 1e-5)).astype(np.uint16)) for shot in FREE]


def test_the_error_of_the_camera_is_learned_with_its_name_and_how_the_membrane_is_mounted(above):
    waves = 3e-4 * np.sin(U / 15) * np.cos(V / 20)
    sagging = 4e-4 * (
        1 - ((V - CAMERA.cy) / CAMERA.cy) ** 2
    )  # by the membrane's own weight, or an error of such a shape
    free = seen_free(through(waves + sagging))
    guessed, known = (
        ran(above(), "learn_pattern", free_membrane=free, mounting=mounting).sinks["pattern"].value
        for mounting in (None, Mounting(0.014, 6e-4, 3e-5))
    )
    assert guessed.camera == known.camera == "camera"
    assert known.hang == pytest.approx(6e-4, abs=6e-5), "no frame shows whose the sag is"
    assert known.hang_sd < 0.5 * guessed.hang_sd
    middle = np.s_[100:230, 60:150]
    assert np.corrcoef(known.error[middle].ravel(), waves[middle].ravel())[0, 1] > 0.8


def test_frames_that_show_nothing_give_no_error_of_the_camera(above):
    unseen = replace(seen_free(), view=FreeView())
    assert ran(above(), "learn_pattern", free_membrane=unseen).sinks["pattern"].value is MISSING


BEFORE = TopReadings((Reading(0.0, 0.002, 0.06, 3e-5),))


@pytest.mark.parametrize("before", [None, BEFORE])
def test_the_height_of_a_first_touch_is_kept_with_what_was_seen(above, before):
    node = ran(above(), "read_first_touch", {"top_readings": before}, frame=frame(0.002), frames=24)
    assert node.status is Status.SUCCESS, node.reason
    *old, reading = node.sinks["top_readings"].value.readings
    assert old == list(before.readings if before else ())
    assert reading.depth == pytest.approx(0.002, abs=2e-4)
    assert reading.hand == pytest.approx(HAND)
    assert (reading.frames, reading.stretch, reading.by_membrane) == (24, 0.0, False)
    assert reading.touch.points.shape == (*frame(0.0).raw.shape, 3)


@pytest.mark.parametrize("before", [None, BEFORE])
def test_a_touch_too_light_to_be_seen_adds_nothing(above, before):
    node = ran(above(), "read_first_touch", {"top_readings": before}, frame=frame(0.0))
    assert node.status is Status.SUCCESS, node.reason
    assert node.sinks["top_readings"].value == (before or TopReadings())


TOP, SOFT = 0.06, 0.2  # m, and how far a top gives way at a depth of 1 mm, as a share of it
GROWS = drop_power(Estimate(0.1, 0.05), POWER)  # power of the depth, in mounts of unknown strain


def touches(soft, depths=(0.001, 0.002, 0.003, 0.004, 0.005), power=GROWS.value):
    return TopReadings(tuple(Reading(0.0, d, TOP - soft * 1e-3 * (d / 1e-3) ** power, 1e-5) for d in depths))


def learned(hang_sd):
    """Return a static error of zero, learned from a membrane whose sag has a standard deviation `hang_sd`, m."""
    zero = np.zeros((2, 2), np.float32)
    return Pattern(zero, zero, left=0.0, hang=0.0, hang_sd=hang_sd, rate=0.0, time=0.0)


@pytest.mark.parametrize("soft", [0.0, SOFT])
def test_the_top_is_where_no_force_would_be(above, soft):
    made = above()
    node = ran(made, "extrapolate_top", top_readings=touches(soft))
    touch, height = node.sinks["touch"].value, node.sinks["contact_height"]
    assert touch.height == pytest.approx(TOP, abs=1e-6)
    assert touch == Touch(height.value, height.sd)
    assert made.context.hand.contact_height == touch.height, "the limits of the cell count from there"


@pytest.mark.parametrize("off", [-1.0, 1.0])
def test_an_object_of_another_law_stands_within_the_deviation_of_its_top(above, off):
    node = ran(above(), "extrapolate_top", top_readings=touches(SOFT, power=GROWS.value + off * GROWS.sd))
    touch = node.sinks["touch"].value
    assert 0.7 < abs(touch.height - TOP) / touch.height_sd < 1.3


def test_what_a_flat_top_lifts_is_taken_off(above):
    plain = TopReadings(tuple(Reading(0.0, d, TOP, 1e-5) for d in (0.002, 0.003)))
    x, y = np.meshgrid(*[np.arange(-40, 41) * 4e-4] * 2)
    disc = np.hypot(x, y) < 0.012
    seen = [np.stack([x, y, np.where(disc, r.depth, 0.0)], axis=-1) for r in plain.readings]
    labels = np.where(disc, CONTACT, UNDEFORMED).astype(np.uint8)
    flat = TopReadings(
        tuple(
            replace(r, touch=FirstTouch(p, np.isfinite(p[..., 2]), labels))
            for r, p in zip(plain.readings, seen, strict=True)
        )
    )
    lower, height = (ran(above(), "extrapolate_top", top_readings=r).sinks["touch"].value for r in (flat, plain))
    assert 2e-5 < height.height - lower.height < 5e-4
    assert lower.height_sd > height.height_sd


def test_how_far_the_membrane_hangs_is_in_the_deviation_of_the_top(above):
    plain, hung = (
        ran(above(), "extrapolate_top", top_readings=touches(SOFT), pattern=pattern).sinks["touch"].value.height_sd
        for pattern in (None, learned(2e-4))
    )
    assert hung == pytest.approx(np.hypot(plain, 2e-4))


@pytest.mark.parametrize("depths", [(), (0.001,), (0.002, 0.002)])
def test_fewer_than_two_depths_show_no_height_without_a_force(above, depths):
    node = ran(above(), "extrapolate_top", top_readings=touches(SOFT, depths))
    assert node.status is Status.FAILURE
    assert len(node.reason) > 20
