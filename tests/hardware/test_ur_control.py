"""What the process of an arm decides, cycle by cycle, without process, client or clock."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.frames import Pose
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.messages import End
from stretch_bt.hardware.ur.control import Control
from stretch_bt.hardware.ur.cycle import Brake, GiveUp, Inputs, Kick, Leave, MakeReady, Say, Servo
from stretch_bt.hardware.ur.guard import MeasuredState
from stretch_bt.hardware.ur.messages import (
    ArmState,
    Beat,
    Engage,
    Engaged,
    Feel,
    Follow,
    Guard,
    Guarded,
    MeanWrench,
    Stop,
    Stopped,
    Zero,
    Zeroed,
)

DT = 0.008
UP = (np.pi, -1.6, 1.8, -1.8, -np.pi / 2, 0.0)
NONE = (0.0,) * 6
#: where the hand stands at first, in the world
BEGIN = Pose((0.0, 0.0, 0.15))


@pytest.fixture(scope="module")
def lab():
    """Settings of the shipped cell of a UR5."""
    spec = load_cell("lab_ur5")
    cell = CellContext(lambda: 0.0, 0, spec.path.parent, Hand(spec.hand), spec.limits)
    return spec.devices["arm"].options.settings(cell)


@dataclass
class Rig:
    """An arm that is at each setpoint a cycle later, led by `Control`."""

    control: Control
    now: float = 100.0
    braking: int = 0
    measured: MeasuredState | None = None
    #: commands of all cycles, and of the latest
    done: list = field(default_factory=list)
    latest: tuple = ()
    force: tuple = (0.0, 0.0, 0.0)
    noise: float = 1e-3

    def __post_init__(self):
        self.state = self.control.begin(self.now)
        self.random = np.random.default_rng(0)
        tool = self.control.mounting.in_base(BEGIN)
        self.measured = MeasuredState(0.0, UP, tool, NONE, NONE, 7, True, 1)

    def cycle(self, *messages, news=True, beat=True, **more):
        """Do a cycle with messages of the driver, and return what was decided."""
        self.now += DT
        wrench = (*(np.array(self.force) + self.noise * self.random.standard_normal(3)).tolist(), 0.0, 0.0, 0.0)
        self.measured = replace(self.measured, time=self.measured.time + DT, wrench=wrench)
        heard = [*messages, *([Beat(None, self.now)] if beat else [])]
        inputs = Inputs(self.measured if news else None, tuple(heard), braking=self.braking > 0, **more)
        self.state, self.latest = self.control.step(self.state, self.now, inputs)
        self.braking = max(self.braking - 1, 0)
        for command in self.latest:
            if isinstance(command, Servo):
                self.measured = replace(self.measured, tool=command.hand)
            elif isinstance(command, Brake):
                self.braking = 3
        self.done.append(self.latest)
        return self.latest

    def cycles(self, count, **more):
        for _ in range(count):
            self.cycle(**more)

    def engage(self):
        """Make ready, as after `Engage` and `Guard`."""
        self.cycle(Engage(1))
        self.cycle(engaged=Engaged(1, None))
        self.cycle(Guard(2))
        return self

    def begin(self, down=0.02, speed=0.05):
        """Begin a motion downwards, and return when it is under way."""
        place = (BEGIN.position[0], BEGIN.position[1], BEGIN.position[2] - down, *BEGIN.rotation)
        self.cycle(Follow(7, (place,), speed))
        self.cycles(10)
        assert self.all(Servo)
        return self

    def all(self, kind):
        """Return all commands of a kind so far."""
        return [command for commands in self.done for command in commands if isinstance(command, kind)]

    def said(self, kind):
        return [say.message for say in self.all(Say) if isinstance(say.message, kind)]


@pytest.fixture
def rig(lab):
    """Return an arm that is ready to move."""
    return Rig(Control(lab)).engage()


def test_an_arm_is_made_ready_and_then_its_watchdog_is_fed(rig):
    assert rig.all(MakeReady) == [MakeReady(1)]
    assert rig.said(Engaged) == [Engaged(1, None)]
    assert rig.said(Guarded) == [Guarded(2, None)]
    assert any(isinstance(command, Kick) for command in rig.cycle())


def test_a_motion_goes_along_its_line_at_its_speed_and_ends_with_a_brake(rig):
    rig.begin(down=0.02, speed=0.05)
    rig.cycles(120)
    heights = [rig.control.mounting.in_world(servo.hand).position[2] for servo in rig.all(Servo)]
    steps = -np.diff(heights)
    assert (steps > -1e-12).all()
    assert steps.max() <= 0.05 * DT * 1.001
    assert heights[-1] == pytest.approx(BEGIN.position[2] - 0.02, abs=1e-4)
    assert len(rig.all(Brake)) == 1
    assert rig.state.motion_state is MotionState.DONE
    assert any(isinstance(command, Kick) for command in rig.latest)


def test_a_second_motion_waits_until_the_first_one_has_braked(rig):
    rig.begin()
    assert any(isinstance(c, Brake) for c in rig.cycle(Follow(8, ((0.0, 0.0, 0.15, *BEGIN.rotation),), 0.05)))
    assert rig.state.motion_state is MotionState.PREEMPTED
    before = len(rig.all(Servo))
    rig.cycle()
    assert len(rig.all(Servo)) == before
    rig.cycles(60)
    assert (rig.state.motion, rig.state.motion_state) == (8, MotionState.DONE)


def test_a_stop_is_answered_once_the_arm_stands(rig):
    rig.begin()
    rig.cycle(Stop(9))
    assert rig.said(Stopped) == []
    rig.cycles(5)
    assert rig.said(Stopped) == [Stopped(9)]
    assert rig.state.motion_state is MotionState.STOPPED


# (what happens in each cycle while the hand goes down, for how many, and what the fault says)
FAULTS = [
    ("safety stop", {"bits": 1 << 2 | 1}, 1, "protective stop"),
    ("program over", {"program": False}, 1, "the control script ended"),
    ("no heartbeat", {"beat": False}, 70, "no sign of life for"),
    ("nobody watches", {"messages": (Beat(None, 0.0),), "beat": False}, 200, "no tick|nobody|looked"),
    ("deaf script", {"taken": False}, 20, "takes no commands"),
    ("mean force", {"force": (0.0, 0.0, 30.0)}, 20, "N is past the limit of the cell, at most 20 N"),
    ("one sample", {"force": (0.0, 0.0, 90.0)}, 1, "in one sample is past"),
    ("standing force", {"noise": 0.0}, 45, "has sent the same force for"),
    ("too fast", {"speed": (0.0, 0.0, -0.4, 0.0, 0.0, 0.0)}, 1, "speed 400 mm/s is past"),
]


@pytest.mark.parametrize(("what", "given_", "count", "said"), FAULTS, ids=[row[0] for row in FAULTS])
def test_what_must_hold_ends_the_motion_and_stays(rig, what, given_, count, said):
    rig.begin(down=0.1, speed=0.02)
    given_ = dict(given_)
    measured = {"safety_bits": given_.pop("bits", 1), "program": given_.pop("program", True)}
    rig.measured = replace(rig.measured, **measured, speed=given_.pop("speed", NONE))
    for name in ("force", "noise"):
        setattr(rig, name, given_.pop(name, getattr(rig, name)))
    messages = given_.pop("messages", ())
    for _ in range(count):
        rig.cycle(*messages, **given_)
    assert rig.state.fault is not None
    with pytest.raises(AssertionError, match=said):
        raise AssertionError(rig.state.fault)
    assert len(rig.all(Brake)) == 1
    before = len(rig.all(Servo)), len(rig.all(Kick))
    rig.force, rig.noise = (0.0, 0.0, 0.0), 1e-3
    rig.measured = replace(rig.measured, safety_bits=1, program=True, speed=NONE)
    rig.cycle(Follow(8, ((0.0, 0.0, 0.15, *BEGIN.rotation),), 0.05))
    rig.cycles(30)
    assert (len(rig.all(Servo)), len(rig.all(Kick))) == before
    assert rig.said(ArmState)[-1].fault == rig.state.fault


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"q": (9.0, *UP[1:])}, "broken"),
        ({"mode": 77}, "broken"),
        ({"wrench": (float("nan"), *NONE[1:])}, "broken"),
    ],
)
def test_what_no_controller_sends_is_a_loss(rig, wrong, said):
    rig.measured = replace(rig.measured, **wrong)
    if "wrench" in wrong:
        rig.noise = float("nan")
    commands = rig.cycle()
    assert [type(command) for command in commands] == [GiveUp]
    assert said in commands[0].reason


def test_silence_of_the_controller_is_a_loss_and_of_this_machine_is_none(rig, lab):
    quiet = int(lab.lost_after / DT) - 2
    rig.cycles(quiet, news=False)
    assert not rig.all(GiveUp)
    rig.now += 1.0
    rig.cycle(news=False, late=1.0)
    assert not rig.all(GiveUp)
    rig.cycles(4, news=False)
    assert "nothing new came from the controller" in rig.all(GiveUp)[0].reason


def test_a_machine_that_stood_still_is_no_silence_of_the_run(rig):
    rig.begin(down=0.1, speed=0.02)
    place = rig.all(Servo)[-1].hand
    rig.now += 2.0
    rig.cycle(beat=False, late=2.0)
    assert rig.state.fault is None
    assert np.linalg.norm(np.subtract(rig.all(Servo)[-1].hand, place)[:3]) <= 3 * 0.02 / 100.0


def test_a_force_gained_on_the_way_blocks_a_motion_where_that_is_asked(lab):
    rig = Rig(Control(replace(lab, contact_force=5.0))).engage()
    rig.cycles(30)
    rig.begin(down=0.1, speed=0.02)
    rig.force = (0.0, 0.0, 8.0)
    rig.cycles(30)
    assert rig.state.motion_state is MotionState.BLOCKED
    assert rig.state.fault is None


def test_a_simulated_controller_without_noise_may_send_one_force_for_ever(lab):
    rig = Rig(Control(replace(lab, noisy=False)), noise=0.0).engage()
    rig.cycles(200)
    assert rig.state.fault is None


def test_force_is_averaged_and_its_zero_taken_off(rig):
    rig.force = (3.0, 0.0, 4.0)
    rig.cycle(Feel(5, 0.2))
    rig.cycles(40)
    (felt,) = rig.said(MeanWrench)
    assert felt.wrench[:3] == pytest.approx((3.0, 0.0, 4.0), abs=1e-2)
    assert felt.count == pytest.approx(0.2 / DT, abs=2)
    rig.cycle(Zero(6, felt.wrench))
    rig.cycles(2)
    assert np.linalg.norm(rig.said(ArmState)[-1].wrench[:3]) < 1e-2


@pytest.mark.parametrize("news", [True, False])
def test_that_a_zero_holds_is_said_after_a_state_that_has_it(rig, news):
    rig.force = (3.0, 0.0, 4.0)
    rig.cycles(20)
    rig.cycle(Zero(6, (3.0, 0.0, 4.0, 0.0, 0.0, 0.0)), news=news)
    rig.cycle()
    said = [say.message for say in rig.all(Say)]
    (zeroed,) = rig.said(Zeroed)
    before = [message for message in said[: said.index(zeroed)] if isinstance(message, ArmState)]
    assert np.linalg.norm(before[-1].wrench[:3]) < 1e-2 < np.linalg.norm(before[-2].wrench[:3])


@pytest.mark.parametrize("missed", [0, 1, 5, 12])
def test_samples_that_do_not_come_leave_the_mean_as_quiet_as_ever(lab, missed):
    rig = Rig(Control(lab), noise=3.6).engage()
    told = []
    for _ in range(100):
        rig.cycles(missed, news=False)
        rig.cycle()
        told.append(rig.said(ArmState)[-1].wrench[:3])
    apart = np.diff(told[16::16], axis=0)
    assert 0.6 * 3.6 / 4 < np.std(apart) / np.sqrt(2) < 1.4 * 3.6 / 4


@pytest.mark.parametrize("missed", [0, 3, 8, 12])
def test_a_limit_sees_a_force_that_rises_as_soon_where_samples_do_not_come(lab, missed):
    rig = Rig(Control(lab)).engage()
    rig.cycles(40)
    while rig.state.fault is None and rig.force[2] < 60.0:
        rig.cycles(missed, news=False)
        rig.force = (0.0, 0.0, rig.force[2] + 20.0 * DT * (1 + missed))
        rig.cycle()
    assert "force" in rig.state.fault
    assert rig.force[2] < 20.0 + 4.0


@pytest.mark.parametrize("pause", [0.05, 0.5, 1.9])
def test_forces_from_before_the_control_script_are_none_of_its_own(lab, pause):
    rig = Rig(Control(lab))
    rig.force = (0.0, 0.0, -25.0)
    rig.cycles(30)
    rig.cycle(Engage(1))
    rig.now += pause
    rig.measured = replace(rig.measured, time=rig.measured.time + pause)
    rig.force = (0.0, 0.0, 0.0)
    rig.cycle(engaged=Engaged(1, None), late=pause)
    rig.cycle(Guard(2))
    [guarded] = rig.said(Guarded)
    assert guarded.reason is None
    assert np.linalg.norm(rig.said(ArmState)[-1].wrench[:3]) < 0.1


def test_a_force_that_rises_is_told_as_soon_after_a_silence(lab):
    rig = Rig(Control(lab)).engage()
    rig.cycles(40)
    rig.cycles(30, news=False)
    rig.force = (0.0, 0.0, 10.0)
    rig.cycles(16)
    assert rig.said(ArmState)[-1].wrench[2] == pytest.approx(10.0, abs=0.01)


def test_an_end_is_obeyed_after_the_brake(rig):
    rig.begin()
    rig.cycle(Stop(9), End())
    assert not rig.all(Leave)
    rig.cycles(5)
    assert len(rig.all(Leave)) == 1


EVENTS = st.sampled_from(["go", "follow", "stop", "silent", "unheard", "late", "load", "safety", "program", "deaf"])


@settings(max_examples=60, deadline=None)
@given(events=st.lists(st.tuples(EVENTS, st.integers(1, 30)), max_size=12), speed=st.floats(0.005, 0.2))
def test_whatever_happens_no_setpoint_leaps_and_none_follows_a_fault(lab, events, speed):
    rig = Rig(Control(lab)).engage()
    for event, count in events:
        rig.force = (0.0, 0.0, 60.0 if event == "load" else 0.0)
        rig.measured = replace(
            rig.measured, safety_bits=1 | (event == "safety") << 2, program=event not in ("program", "safety")
        )
        if event == "follow":
            rig.cycle(Follow(count, ((0.0, 0.0, 0.1 + 0.002 * count, *BEGIN.rotation),), speed))
        if event == "stop":
            rig.cycle(Stop(count))
        if event == "late":
            rig.now += 0.1 * count
        more = {"late": 0.1 * count} if event == "late" else {}
        for k in range(count):
            rig.cycle(
                news=event != "silent", beat=event != "unheard", taken=event != "deaf", **(more if k == 0 else {})
            )
            if rig.all(GiveUp):
                return
    last, faulty = None, False
    for commands in rig.done:
        servos = [c for c in commands if isinstance(c, Servo)]
        assert len(servos) + sum(isinstance(c, Brake) for c in commands) <= 1
        states = [c.message for c in commands if isinstance(c, Say) and isinstance(c.message, ArmState)]
        assert not (faulty and servos)
        faulty = faulty or any(state.fault for state in states)
        for servo in servos:
            if last is not None:
                assert np.linalg.norm(np.subtract(servo.hand, last)[:3]) <= speed * 3.1 / 100.0
            last = servo.hand
        if any(isinstance(c, Brake) for c in commands):
            last = None
