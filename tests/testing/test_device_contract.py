"""The contract of devices finds what is wrong with a driver, and says what it could not see: faults planted in the drivers of `new device`."""

import itertools
import multiprocessing
import os
import signal
import subprocess
import sys
import time

import pytest

from stretch_bt.cli.command_new import command
from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.frames import Pose
from stretch_bt.testing import device_contract
from stretch_bt.testing.contract import simulator
from stretch_bt.testing.contract.touches import touches

TERMS = {
    "Arm": {
        "moves": (Pose((0, 0, 0.2)), Pose((0, 0, 0.23), (0, 0, 0.2))),
        "tolerance": 0.0005,
        "latency": 0.2,
    },
    "Gripper": {"moves": (0.060, 0.080), "tolerance": 0.0005, "latency": 0.2},
    "DepthCamera": {"tolerance": 0.001, "latency": 0.2},
    "ForceSensor": {"tolerance": 0.1, "latency": 0.2},
}
NAMES = (f"planted_driver_{number}" for number in itertools.count())


@pytest.fixture
def contract(tmp_path, monkeypatch):
    """Write the driver of `new device` with texts changed, and give its contract."""
    monkeypatch.chdir(tmp_path)

    def make(kind, *changes, options="", **terms):
        name = next(NAMES)
        command("device", name, kind)
        path, cell = tmp_path / f"{name}.py", tmp_path / f"{name}.yaml"
        text = path.read_text()
        for old, new in changes:
            assert old in text, f"the driver has another text than {old!r}"
            text = text.replace(old, new)
        path.write_text(text)
        cell.write_text(cell.read_text().replace(f"use: {name}}}", f"use: {name}{options}}}"))
        (device,) = (line.split(":")[0].strip() for line in cell.read_text().splitlines() if f"type: {kind}" in line)
        return device_contract(cell, device, **(TERMS[kind] | terms))

    yield make
    for name in [name for name in sys.modules if name.startswith("planted_driver_")]:
        del sys.modules[name]


def verdict(made, clause):
    """Return what comes of a clause: passed, failed or skipped, and why."""
    case = made()
    with made.contract.trial() as case.trial:
        try:
            getattr(case, clause)()
        except pytest.fail.Exception as failure:
            return "failed", str(failure)
        except pytest.skip.Exception as skipped:
            return "skipped", str(skipped)
    return "passed", ""


def clauses_of(made):
    return [name for name in dir(made) if name.startswith("test_")]


def reason_of(test):
    """Return why a test is skipped before anything is brought up for it, or None."""
    return next((mark.kwargs["reason"] for mark in getattr(test, "pytestmark", ()) if mark.name == "skip"), None)


LOADED = {"load": lambda sensor: sensor.driver.do(lambda link: setattr(link, "force", (0.0, 0.0, 5.0)))}
ZERO = "test_zero_takes_the_present_wrench_as_zero"
READ = "        return 0.1, -0.2, 4.0\n"
HOST = "        self.offset = self.latest().value\n"
LINK = "    def connect(self)"
#: a sensor that zeroes itself, and feels what the test puts on it
OWN_ZERO = (
    (READ, "        return tuple(f - z for f, z in zip(self.force, self.zeroed))\n"),
    (
        LINK,
        "    force, zeroed = (0.1, -0.2, 4.0), (0.0, 0.0, 0.0)\n\n"
        "    def zero(self) -> None:\n        self.zeroed = self.force\n\n    def connect(self)",
    ),
)
WAITS = "        begun = self.command(lambda link: link.zero())\n        while self.since(begun) is None:\n            pass\n"
DEAD = ((READ, "        return 0.0, 0.0, 0.0\n"),)


@pytest.mark.parametrize(
    ("changes", "terms", "outcome", "said"),
    [
        ((), {}, "passed", ""),
        ((*OWN_ZERO, (HOST, WAITS)), {}, "passed", ""),
        ((*OWN_ZERO, (HOST, WAITS)), LOADED, "passed", ""),
        (
            (*OWN_ZERO, (HOST, "        self.do(lambda link: link.zero())\n")),
            {},
            "failed",
            "the first reading after zero() is 4.01 N",
        ),
        (
            (*OWN_ZERO, (HOST, "        self.do(lambda link: link.zero())\n")),
            LOADED,
            "failed",
            "the first reading after zero() is 5 N",
        ),
        (((HOST, "        pass\n"),), {}, "failed", "after zero() the sensor reads 4.01 N"),
        (
            (*DEAD, (HOST, "        pass\n")),
            {},
            "skipped",
            "what zero() does cannot be seen: the sensor read 0 N before it",
        ),
        ((*DEAD, (HOST, "        pass\n")), LOADED, "failed", "the sensor reads 0 N before its load and under it"),
    ],
    ids=[
        "of the host",
        "of the sensor",
        "under a load",
        "old",
        "old under a load",
        "none",
        "dead",
        "dead under a load",
    ],
)
def test_what_zero_does_is_seen(contract, changes, terms, outcome, said):
    # the sensor is asked so seldom that a reading from before is there as zero() returns
    found, why = verdict(contract("ForceSensor", *changes, options=", rate: 5 Hz", latency=0.5, **terms), ZERO)
    assert found == outcome, why
    assert said in why


REACHES = {
    "a UDP connection": "import socket; s = socket.socket(2, 2); s.connect(('127.0.0.1', 9)); s.close()",
    "a datagram": "import socket; s = socket.socket(2, 2); s.sendto(b'', ('127.0.0.1', 9)); s.close()",
    "a port": "import socket; s = socket.socket(2, 2); s.bind(('127.0.0.1', 0)); s.close()",
    "a shell": "import os; os.system('true')",
    "a program": "import subprocess; subprocess.run(['true'])",
    "a spawned program": "import os; os.waitpid(os.posix_spawn('/bin/true', ['true'], {}), 0)",
    "a fork": "import os\n        child = os.fork()\n        child or os._exit(0)\n        os.waitpid(child, 0)",
    "a serial line": "import pty, os; [os.close(f) for f in pty.openpty()]; open('/dev/ptmx', 'rb').close()",
    "a process of Python": "import multiprocessing as m; self.p = m.get_context('spawn').Process(target=print); self.p.start()",
    "a datagram of a thread": "import socket, threading; s = socket.socket(2, 2)\n"
    "        t = threading.Thread(target=lambda: s.sendto(b'', ('127.0.0.1', 9))); t.start(); t.join(); s.close()",
}


@pytest.mark.parametrize("how", REACHES)
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_constructor_that_reaches_out_is_found(contract, how):
    init = f"    def __init__(self, *given) -> None:\n        super().__init__(*given)\n        {REACHES[how]}\n\n    def wire(self)"
    if how == "a process of Python":
        init += "  "
    made = contract("ForceSensor", ("    def wire(self)", init.rstrip()))
    found, why = verdict(made, "test_constructing_touches_nothing")
    assert found == "failed", why
    assert "connect in open()" in why


def test_what_other_threads_and_ordinary_files_do_is_no_touch(tmp_path):
    with touches() as touched:
        (tmp_path / "a").write_text("a")
        open("/dev/null").close()  # noqa: PTH123
    assert touched == []


@pytest.mark.parametrize(
    ("changes", "terms", "outcome", "said"),
    [
        ((), {}, "passed", ""),
        (
            (("[self.read()[0], *path]", "[self.read()[0], *(Pose(pose.position) for pose in path)]"),),
            {},
            "failed",
            "the hand is 11.5° off the rotation that it was sent to, at most 0.57° allowed, 0.5 mm at the edge of the membrane: "
            "rotations are not sent, or not read",
        ),
        (
            (("[self.read()[0], *path]", "[self.read()[0], *(Pose(p.position, p.rotation[::-1]) for p in path)]"),),
            {},
            "failed",
            "rotations are rotation vectors, rad",
        ),
        (
            (),
            {"moves": (Pose((0, 0, 0.2)), Pose((0, 0, 0.23)))},
            "skipped",
            "have the same rotation; name two that differ",
        ),
    ],
    ids=["turns", "ignores", "turns about another axis", "not asked"],
)
def test_an_arm_that_does_not_turn_as_it_is_sent_is_found(contract, changes, terms, outcome, said):
    found, why = verdict(contract("Arm", *changes, **terms), "test_the_hand_turns_as_it_is_sent")
    assert found == outcome, why
    assert said in why


HOLD = "        wire.go(wire.read()[0], 1.0)\n"
STOP, REPLACE = "test_stop_ends_a_motion", "test_a_new_command_replaces_the_motion"
LATE = ((HOLD, f"        time.sleep(0.9)\n{HOLD}"), ("    use =", "    deadline = 5.0\n    use ="))
QUEUED = (
    (
        "        self.begin, self.end, self.speed, self.since = self.read()[0], opening, speed, time.monotonic()\n",
        "        while self.read()[1]:\n            time.sleep(0.01)\n"
        "        self.begin, self.end, self.speed, self.since = self.read()[0], opening, speed, time.monotonic()\n",
    ),
    ("    use =", "    deadline = 20.0\n    use ="),
)


@pytest.mark.parametrize(
    ("changes", "moves", "clause", "outcome", "said"),
    [
        ((), (0.060, 0.065), STOP, "passed", ""),
        ((), (0.060, 0.065), REPLACE, "passed", ""),
        (((HOLD, "        pass\n"),), (0.060, 0.080), STOP, "failed", "went on to its target"),
        (((HOLD, "        pass\n"),), (0.060, 0.065), STOP, "failed", "went on to its target"),
        (
            LATE,
            (0.056, 0.134),
            STOP,
            "failed",
            "after stop() the device went on",
        ),
        (((HOLD, f"{HOLD}        time.sleep(0.6)\n"),), (0.056, 0.134), STOP, "failed", "stop() took 0.6"),
        (
            LATE,
            (0.056, 0.134),
            "test_closing_ends_a_motion",
            "failed",
            "after close() the device went on",
        ),
        (QUEUED, (0.060, 0.080), REPLACE, "failed", "after a new command, at most"),
        ((), (0.060, 0.0605), STOP, "skipped", "are 0.5 mm apart, too near to see within 0.5 mm whether"),
        ((), (0.060, 0.0605), REPLACE, "skipped", "name places at least 4 mm apart"),
    ],
)
def test_a_motion_that_goes_on_is_seen_also_between_near_places(contract, changes, moves, clause, outcome, said):
    found, why = verdict(contract("Gripper", *changes, moves=moves, latency=0.1), clause)
    assert found == outcome, why
    assert said in why


@pytest.mark.parametrize(("rate", "latency"), [(2, 0.6), (1, 1.2)])
def test_a_slow_camera_holds_the_contract(contract, rate, latency):
    made = contract("DepthCamera", options=f", rate: {rate} Hz", latency=latency)
    for clause in (name for name in clauses_of(made) if "reading" in name or "frame" in name):
        found, why = verdict(made, clause)
        assert found == "passed", why


def test_a_slow_camera_that_stands_still_is_found(contract):
    frozen = ("        sample = self.latest()\n", "        sample = self.__dict__.setdefault('kept', self.latest())\n")
    made = contract("DepthCamera", frozen, options=", rate: 2 Hz", latency=0.6)
    assert verdict(made, "test_numbers_grow_with_new_readings") == (
        "failed",
        "frame() gave only 1 new numbers in 1.8 s: give each new reading a higher number, or read the device more often",
    )


@pytest.mark.parametrize("kind", TERMS)
def test_what_is_left_out_is_skipped_with_what_to_give(contract, kind):
    made = contract(kind, moves=None)
    skipped = {name: why for name in clauses_of(made) if (why := reason_of(getattr(made, name))) is not None}
    lost = [why for name, why in skipped.items() if name == "test_a_loss_is_a_fault_that_stays"]
    assert lost == ["`cut` was left out, so no loss is tested: name what breaks the connection"]
    if kind in ("Arm", "Gripper"):
        for name in ("test_opening_moves_nothing", STOP, "test_a_loss_during_a_motion_is_told"):
            assert skipped[name].startswith("`moves` was left out, so nothing moves")
    else:
        assert list(skipped) == ["test_a_loss_is_a_fault_that_stays"]
        assert "test_opening_moves_nothing" not in clauses_of(made)
    whole = contract(kind, cut=lambda: None)
    assert not any(reason_of(getattr(whole, name)) for name in clauses_of(whole))


STUBBORN = (
    "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('up', flush=True); time.sleep(600)"
)


@pytest.mark.parametrize("ends", [True, False], ids=["ends", "does not end"])
def test_a_process_as_simulator_is_ended(contract, monkeypatch, ends):
    monkeypatch.setattr(simulator, "_ENDING", 20.0 if ends else 0.2)
    begun = []

    def start():
        code = STUBBORN.replace("SIG_IGN", "SIG_DFL") if ends else STUBBORN
        process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
        assert process.stdout.readline() == b"up\n"
        begun.append(process)
        return process

    found, why = verdict(contract("ForceSensor", start=start), "test_open_and_close_as_often_as_wanted")
    assert found == "passed", why
    assert [process.returncode for process in begun] == [-signal.SIGTERM if ends else -signal.SIGKILL]


def test_a_process_of_python_as_simulator_is_ended(contract):
    begun = []

    def start():
        process = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(600,))
        process.start()
        begun.append(process.pid)
        return process

    found, why = verdict(contract("ForceSensor", start=start), "test_open_and_close_as_often_as_wanted")
    assert found == "passed", why
    assert multiprocessing.active_children() == []
    for pid in begun:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


@pytest.mark.parametrize("wrong", ["cell file", "device", "kind"])
def test_a_generator_as_simulator_is_ended_where_the_cell_is_wrong(tmp_path, wrong):
    ended = []

    def start():
        yield "simulator"
        ended.append("simulator")

    path = tmp_path / "cell.yaml"
    path.write_text("format: stretch-cell/1\ndevices: {arm: {type: Arm, use: simulated}}\n")
    cell, device, kind = {
        "cell file": (lambda _: tmp_path / "none.yaml", "arm", None),
        "device": (lambda _: path, "amr", None),
        "kind": (lambda _: path, "arm", "Gripper"),
    }[wrong]
    said = {"cell file": "no such file", "device": "no device 'amr', but arm", "kind": "write kind='Arm'"}[wrong]
    with pytest.raises(StretchError, match=said):  # noqa: PT012
        made = device_contract(cell, device, start=start, kind=kind, tolerance=0.001, latency=0.2)
        with made.contract.trial():
            pass
    assert ended == ["simulator"]


def test_a_generator_without_a_simulator_and_a_kind_without_a_contract_are_told():
    terms = {"tolerance": 0.001, "latency": 0.2}
    with pytest.raises(InvalidInput, match="no contract of the kind 'arm'; did you mean 'Arm'"):
        device_contract("simulated", "arm", kind="arm", **terms)
    with pytest.raises(InvalidInput, match="'start' yields nothing; yield the simulator once"):
        device_contract(lambda _: "simulated", "arm", start=lambda: (_ for _ in ()), **terms)


def test_one_simulator_is_up_at_a_time(contract):
    up = []

    class OnOnePort:
        def __enter__(self):
            assert not up, "its port is in use"
            up.append(self)

        def __exit__(self, *_):
            up.remove(self)

    found, why = verdict(contract("ForceSensor", start=OnOnePort), "test_constructing_touches_nothing")
    assert found == "passed", why
    assert not up
