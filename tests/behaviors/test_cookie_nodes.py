"""Nodes that shape dough, one by one."""

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from stretch_bt import check
from stretch_bt.behaviors._spread import spread_of
from stretch_bt.behaviors.measure_roundness import _spread, _width
from stretch_bt.behaviors.records import LumpLook, Touch
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.perception import FreeView
from stretch_bt.perception.types import Contact
from stretch_bt.runtime.context import RunContext
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Role, Status
from stretch_bt.tree.registry import lookup

TOUCHED, BALL = 0.030, 0.0155
START = Pose((0.02, -0.01, TOUCHED))


def node(name, arm=None, **inputs):
    info = lookup(name)
    made = info.cls(f"main/{name}")
    made.context = RunContext()
    made.context.devices = {} if arm is None else {"arm": arm}
    made.device_names = {p.name: p.name for p in info.of(Role.DEVICE) if p.name in made.context.devices}
    inputs = {"touch": Touch(TOUCHED, 0.0), **inputs}
    for p in info.of(Role.INPUT):
        made.wiring[p.name] = partial(inputs.get, p.name, p.default)
    return made


def tick(made, times=1):
    for _ in range(times):
        for _ in made.tick():
            pass
    return made.status


def told(made, name):
    return made.sinks[name].value


def arm(force=1.0, motion=(MotionState.MOVING, MotionState.DONE), pose=START):
    along = tuple(force * pose.matrix()[:, 2])
    return ScriptedDevice("Arm", {"pose": pose, "wrench": Wrench(along)}, motion=list(motion))


def device_of(made):
    return made.context.devices["arm"]


def paths(device):
    return [[p.position for p in c.arguments["path"]] for c in device.commands if c.name == "follow"]


@pytest.mark.parametrize("shape", ["circle", "eight"])
@pytest.mark.parametrize("yaw", [0.0, math.pi / 2])
def test_a_lap_is_closed_and_turns_with_the_hand(shape, yaw):
    device = arm(pose=Pose(START.position, (0.0, 0.0, yaw)))
    roll = node("roll", device, shape=shape, radius=0.02, depth=0.004)
    assert tick(roll, 2) is Status.SUCCESS
    (path,) = paths(device)
    assert path[0] == pytest.approx((*START.position[:2], TOUCHED - 0.004))
    assert path[-1] == pytest.approx(path[0])
    x, y = np.ptp(np.array(path)[:, :2], axis=0) if yaw == 0 else np.ptp(np.array(path)[:, :2], axis=0)[::-1]
    assert (x, y) == pytest.approx((0.04, 0.04) if shape == "circle" else (0.4 * 0.04, 0.04), rel=1e-3)
    assert told(roll, "travel") == pytest.approx(sum(math.dist(a, b) for a, b in pairwise(path)))


def test_it_rolls_lap_after_lap_until_it_is_stopped():
    device = arm(motion=[MotionState.DONE])
    roll = node("roll", device, laps=0)
    assert tick(roll, 50) is Status.RUNNING
    assert len(paths(device)) == 51
    roll.stop(Status.INVALID)
    assert roll.motion is None


@pytest.mark.parametrize("lean", [0.0, 0.8])
@pytest.mark.parametrize(("force", "wanted", "lower"), [(0.5, 1.0, True), (1.3, 1.0, False)])
def test_the_height_follows_the_force_along_the_hands_axis(force, wanted, lower, lean):
    device = arm(force, pose=Pose(START.position, (lean, 0.0, 0.0)))
    roll = node("roll", device, shape="eight", force=wanted, depth=0.004, laps=1)
    assert tick(roll, 16) is Status.SUCCESS
    heights = [path[0][2] for path in paths(device)]
    assert len(heights) == 8, "a leg for each eighth of a lap"
    assert all(
        path[0][:2] == pytest.approx(before[-1][:2])
        for before, path in zip(paths(device), paths(device)[1:], strict=False)
    )
    assert (heights[1] < heights[0]) == lower
    assert min(heights) >= TOUCHED - 0.004 - 1e-12
    assert told(roll, "mean_force") == pytest.approx(force)


def test_nothing_under_the_hand_is_a_failure():
    roll = node("roll", arm(0.0), force=1.0, depth=0.002, laps=0)
    while tick(roll) is Status.RUNNING:
        assert len(device_of(roll).commands) < 50
    assert roll.status is Status.FAILURE
    assert "nothing is under the hand" in roll.reason
    assert len(paths(device_of(roll))) >= 8, "a place where it is too low to be felt is no loss"


def test_what_is_felt_again_within_a_lap_is_not_lost():
    felt = [Wrench((0.0, 0.0, force)) for force in (*[0.0] * 7, 1.0)]
    device = ScriptedDevice("Arm", {"pose": START, "wrench": 6 * felt}, motion=[MotionState.DONE])
    roll = node("roll", device, force=1.0, depth=0.002, laps=0)
    assert tick(roll, 40) is Status.RUNNING, roll.reason


@pytest.mark.parametrize("motion", [MotionState.MOVING, MotionState.DONE])
def test_too_much_force_stops_it_however_short_a_piece_is(motion):
    device = arm(5.0, motion=[motion])
    roll = node("roll", device, max_force=4.0, laps=0)
    assert tick(roll) is Status.FAILURE
    assert "5.00 N exceeds" in roll.reason
    assert [c.name for c in device.commands][:2] == (["follow", "stop"] if motion is MotionState.MOVING else ["follow"])


@pytest.mark.parametrize("force", ["-0.5 N", "0 N"])
def test_a_force_that_would_raise_the_hand_for_ever_is_refused(tmp_path, force):
    tree = "format: stretch-tree/1\ndevices: {arm: Arm}\ntrees:\n  main:\n    roll: {force: %s}\n"
    (tmp_path / "tree.yaml").write_text(tree % force)
    assert "out-of-bounds" in [d.code for d in check([tmp_path / "tree.yaml"])]


def test_heights_settle_when_enough_of_them_are_alike():
    made = node("height_settled", count=3, limit=0.001)
    seen = []
    for height in (0.030, 0.034, 0.031, 0.0312, 0.0311):
        made.wiring["height"] = lambda height=height: height
        assert tick(made) is Status.SUCCESS
        seen.append(told(made, "settled"))
    assert seen == [False, False, False, False, True]
    assert told(made, "spread") == pytest.approx(np.std([0.031, 0.0312, 0.0311], ddof=1))
    made.wiring["reset"] = lambda: True
    tick(made)
    assert not told(made, "settled")
    assert told(made, "heights").values == (0.0311,)


def seen_from(shape, noise=0.0, seed=0, at=(0.0, 0.0), lift=0.009):
    """The contact that a body of heights shape(x, y), m, over its middle shows, on a grid of 0.4 mm."""
    v, u = np.mgrid[:120, :120]
    x, y = (u - 60) * 0.4e-3, (v - 60) * 0.4e-3
    heights = np.maximum(shape(x, y), -0.004) + lift + noise * np.random.default_rng(seed).standard_normal(x.shape)
    surface = np.stack([x + at[0], y + at[1], heights], axis=2)
    labels = np.where(heights > lift - 0.004, 2, 0).astype(np.uint8)
    points = surface[labels == 2]
    rays = points - [0.0, 0.0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    pose = Pose((0.05, 0.02, 0.02))
    return Contact(points, rays, labels, max(noise, 1e-6), 0.02, 0.0, 0.0, surface, np.ones(labels.shape), pose)


def facetted(angle, oval):
    """A ball that is longer by `oval` along a direction in the plane."""

    def shape(x, y):
        along = x * math.cos(angle) + y * math.sin(angle)
        across = -x * math.sin(angle) + y * math.cos(angle)
        return -((along / (1 + oval)) ** 2 + (across * (1 + oval)) ** 2) / (2 * BALL)

    return shape


def looked(shape_of, heights, count=6, **inputs):
    """Return `measure_roundness` after it looked at several ways that a lump lay."""
    made = node("measure_roundness", radius=BALL, count=count, **inputs)
    for k, height in enumerate(heights):
        made.wiring["contact"] = lambda k=k: seen_from(shape_of(k), 1e-4, k, at=(1e-3 * k, 0.0))
        made.wiring["height"] = lambda height=height: height
        assert tick(made) is Status.SUCCESS, made.reason
        assert told(made, "lump_looks").count == min(k + 1, count)
    return made


LIMITS = {"residual": 0.004, "spread": 0.08, "width": 1.05}  # within which a lump is a ball


@pytest.mark.parametrize("oval", [0.0, 0.05, 0.2])
def test_roundness_distinguishes_an_oval_from_a_ball(oval):
    made = looked(lambda k: facetted(k * 0.5, oval), [2 * BALL * (1 + oval * math.cos(k)) for k in range(6)])
    residual = made.sinks["residual"]
    assert residual.value == pytest.approx({0.0: 0.0, 0.05: 0.007, 0.2: 0.0285}[oval], abs=0.002)
    assert residual.sd > 0
    assert told(made, "width") == pytest.approx(1.0, abs=0.1)
    assert all(told(made, name) <= limit for name, limit in LIMITS.items()) == (oval == 0.0)


def test_one_look_says_nothing_of_how_round_a_lump_is():
    made = looked(lambda _: facetted(0.0, 0.0), [2 * BALL])
    assert told(made, "residual") == told(made, "spread") == made.sinks["spread"].sd == made.sinks["width"].sd == 1.0
    settled = node("height_settled", height=2 * BALL)
    tick(settled)
    assert settled.sinks["spread"].value == settled.sinks["spread"].sd == 0.1


@pytest.mark.parametrize("count", [2, 3, 6])
def test_spreads_are_as_far_off_as_they_say(count):
    draws = 0.04 + np.random.default_rng(0).normal(0.0, 1e-3, (4000, count))
    looks = [tuple(LumpLook(None, height, None) for height in heights) for heights in draws]
    widths = [_width(each, 0.02) for each in looks]
    errors = [[width - 1.0 for width in widths]]
    stated = [widths]
    for spreads, true in (
        ([_spread(each, 0.02) for each in looks], 0.05),
        ([spread_of(tuple(h), 0.0) for h in draws], 1e-3),
    ):
        assert np.mean(np.square(spreads)) == pytest.approx(true**2, rel=0.1)
        errors.append([spread - true for spread in spreads])
        stated.append(spreads)
    for off, said in zip(errors, stated, strict=True):
        assert np.mean(np.square(off)) == pytest.approx(np.mean([one.sd**2 for one in said]), rel=0.25)


def test_an_error_that_all_heights_share_stays_in_their_mean():
    made = looked(lambda _: facetted(0.0, 0.0), [2 * BALL] * 4, height_sd=1e-3)
    assert made.sinks["width"].sd == pytest.approx(1e-3 / (2 * BALL))
    assert made.sinks["spread"].sd == pytest.approx(1e-3 / BALL / math.sqrt(6))


def test_only_the_last_looks_count():
    heights = [3 * BALL, 3 * BALL, 2 * BALL, 2.02 * BALL]
    made = looked(lambda _: facetted(0.0, 0.0), heights, count=2)
    assert [look.height for look in told(made, "lump_looks").looks] == pytest.approx(heights[2:])
    assert told(made, "width") == pytest.approx(1.005)
    assert told(made, "spread") == pytest.approx(0.01 * math.sqrt(2))


@pytest.mark.parametrize(("level", "drawn"), [(None, False), (0.003, True)])
def test_level_lines_are_drawn_where_a_level_is_given(level, drawn):
    made = looked(lambda _: facetted(0.0, 0.0), [2 * BALL] * 2, level=level)
    assert told(made, "outline") == pytest.approx(1.0 if drawn else 0.0, abs=0.05)


def test_roundness_refuses_what_shows_nothing():
    made = node("measure_roundness", radius=BALL, contact=seen_from(lambda x, y: -0.012 + 0 * x, lift=0.0), height=0.03)
    assert tick(made) is Status.FAILURE
    assert "nothing stands" in made.reason


def test_the_hand_goes_over_what_it_touched():
    device = arm(pose=Pose((0.0, 0.0, 0.02)))
    made = node("move_over_contact", device, contact=seen_from(facetted(0.0, 0.0), at=(0.004, 0.007)), clearance=0.01)
    assert tick(made, 2) is Status.SUCCESS
    (path,) = paths(device)
    assert path[0] == pytest.approx((0.0, 0.0, 0.03))
    assert path[1] == pytest.approx((0.05 + 0.004, 0.02 - 0.007, 0.03), abs=1e-4), (
        "y of the membrane is against the hand's"
    )


def test_a_lower_patch_that_looks_touched_does_not_draw_the_hand_aside():
    device = arm(motion=[MotionState.DONE], pose=Pose((0.0, 0.0, 0.02)))
    seen = seen_from(facetted(0.0, 0.0), at=(0.004, 0.007))
    aside = np.repeat([[0.0, -0.055, seen.points[:, 2].min() - 0.003]], 2 * len(seen.points), axis=0)
    made = node(
        "move_over_contact", device, contact=replace(seen, points=np.vstack([seen.points, aside])), clearance=0.01
    )
    assert tick(made, 2) is Status.SUCCESS
    assert paths(device)[0][1] == pytest.approx((0.05 + 0.004, 0.02 - 0.007, 0.03), abs=5e-4)


@pytest.mark.parametrize(
    ("pulled", "least", "adhering"), [(0.0, 0.4e-3, False), (1e-3, 0.4e-3, True), (1e-3, 2e-3, False)]
)
def test_what_adheres_to_the_membrane_shows_against_how_it_hung_before(pulled, least, adhering):
    lens, view = Intrinsics(475.0, 475.0, 100.0, 110.0, 200, 220), FreeView()
    for number in range(30):
        view.add(DepthFrame(np.full((220, 200), 1600, np.uint16), 1.25e-4, lens, number / 30, number, 0.2, stretch=0.0))
    view.settle()
    lower = DepthFrame(np.full((220, 200), round((0.2 + pulled) / 1.25e-4), np.uint16), 1.25e-4, lens, 2.0, 60, 0.2)
    made = node("detect_adhesion", frame=lower, least=least, pattern=view.pattern(0.1))
    assert tick(made) is Status.SUCCESS, made.reason
    assert told(made, "adhering") == adhering
    assert told(made, "pulled") == pytest.approx(pulled, abs=0.35e-3)


def test_adhesion_shows_only_against_a_pattern_that_was_learned(tmp_path):
    tree = (
        "format: stretch-tree/1\ndevices: {camera: DepthCamera}\ntrees:\n  main:\n    sequence:\n"
        "      - average_frames\n      - detect_adhesion\n"
    )
    (tmp_path / "tree.yaml").write_text(tree)
    errors = [d.message for d in check([tmp_path / "tree.yaml"]) if d.severity == "error"]
    assert any("pattern" in message for message in errors)
