"""The thread that has a wire to itself."""

import threading
import time

import pytest
from waiting import broken_off

from stretch_bt.errors import DeviceFault, DeviceLost, NotReady
from stretch_bt.hardware.attendant import Attendant, WireError


class Counting:
    """A wire that counts; what is in `broken` is raised, and `gate` holds it up."""

    def __init__(self):
        self.value = 0
        self.broken = None
        self.gate = threading.Event()
        self.gate.set()
        self.said = []

    def connect(self):
        self.said.append("connect")
        if self.broken:
            raise self.broken

    def read(self):
        self.gate.wait()
        if self.broken:
            raise self.broken
        self.value += 1
        return self.value

    def close(self):
        self.said.append("close")


@pytest.fixture
def wire():
    return Counting()


@pytest.fixture
def attend(wire):
    made = []

    def make(deadline=5.0, period=0.002):
        attendant = Attendant(
            "d",
            wire,
            period=period,
            deadline=deadline,
            now=time.monotonic,
            after_poll=lambda w, sample: None,
            on_return=lambda w: w.said.append("return"),
        )
        made.append(attendant)
        attendant.start()
        return attendant

    yield make
    wire.gate.set()
    for attendant in made:
        attendant.end()
    assert not [t for t in threading.enumerate() if t.name.startswith("attendant")]


def until(ask):
    end = time.monotonic() + 20
    while time.monotonic() < end:
        if answer := ask():
            return answer
        time.sleep(0.002)
    raise AssertionError("it does not come")


def lost(attendant):
    try:
        attendant.latest()
    except DeviceLost as fault:
        return fault
    return None


def test_it_polls_and_runs_jobs_in_one_thread(attend, wire):
    attendant = attend()
    first = attendant.latest()
    until(lambda: attendant.latest().number > first.number + 3)
    assert attendant.do(lambda w: threading.current_thread().name) == "attendant of d"
    assert attendant.refresh().value == wire.value
    attendant.end()
    assert wire.said == ["connect", "close"]


@pytest.mark.parametrize("error", [WireError("cable"), ConnectionResetError("cable"), ValueError("cable")])
def test_a_wire_that_does_not_connect_leaves_nothing(attend, wire, error):
    wire.broken = error
    with pytest.raises(DeviceLost, match=r"d: it does not answer.*cable"):
        attend()


def test_a_client_that_is_missing_is_said_as_it_is(attend, wire):
    wire.broken = ImportError("install it")
    with pytest.raises(ImportError, match="install it"):
        attend()


def test_a_wire_that_hangs_at_first(attend, wire):
    wire.gate.clear()
    timer = threading.Timer(0.3, wire.gate.set)
    timer.start()
    with pytest.raises(DeviceLost, match=r"no answer within 0.05 s"):
        attend(deadline=0.05)
    timer.join()


@pytest.mark.parametrize("error", [WireError("cable"), BrokenPipeError("cable"), KeyError("cable")])
def test_a_loss_is_told_while_it_lasts_and_once_after(attend, wire, error):
    attendant = attend()
    wire.broken = error
    until(lambda: lost(attendant))
    assert "cable" in str(lost(attendant))
    with pytest.raises(DeviceLost, match="still down"):
        attendant.acknowledge()
    with pytest.raises(DeviceLost, match="down"):
        attendant.do(lambda w: 1)
    wire.broken = None
    until(lambda: lost(attendant) is None)
    assert wire.said[-1] == "return"
    with pytest.raises(NotReady, match="nobody acknowledged it"):
        attendant.check_acknowledged()
    attendant.acknowledge()
    attendant.check_acknowledged()


def test_a_short_loss_between_two_looks_is_told(attend, wire):
    attendant = attend()
    wire.broken = WireError("cable")
    until(lambda: "return" not in wire.said and wire.said.count("close") > 0)
    wire.broken = None
    until(lambda: "return" in wire.said)
    number = wire.value
    until(lambda: wire.value > number + 2)
    assert "cable" in str(lost(attendant))
    assert lost(attendant) is None


def test_a_job_that_is_too_late_is_not_begun(attend, wire):
    attendant = attend(deadline=0.2)
    wire.gate.clear()
    begun = []
    until(lambda: not wire.gate.is_set())
    time.sleep(0.02)
    with pytest.raises(DeviceLost, match=r"not answered within 0.2 s"):
        attendant.do(begun.append)
    assert "no answer for" in str(lost(attendant))
    with pytest.raises(NotReady):
        attendant.check_acknowledged()
    wire.gate.set()
    number = wire.value
    until(lambda: wire.value > number + 3)
    assert begun == []


def test_a_job_that_breaks_the_wire_is_a_loss_and_one_that_refuses_is_not(attend, wire):
    attendant = attend()

    def refuse(_):
        raise DeviceFault("d", "no")

    def break_it(_):
        raise OSError("cut")

    with pytest.raises(DeviceFault, match="d: no"):
        attendant.do(refuse)
    attendant.check_acknowledged()
    with pytest.raises(DeviceLost, match="cut"):
        attendant.do(break_it)
    until(lambda: "return" in wire.said)
    with pytest.raises(NotReady):
        attendant.check_acknowledged()


def test_ctrl_c_before_the_first_reading_ends_the_thread(attend, wire):
    wire.gate.clear()
    with broken_off(lambda: wire.said):
        attend()
    wire.gate.set()
    until(lambda: "attendant of d" not in [thread.name for thread in threading.enumerate()])
    assert wire.said == ["connect", "close"]
