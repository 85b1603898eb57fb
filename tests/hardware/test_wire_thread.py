"""The thread that has a wire to itself."""

import threading
import time

import pytest
from waiting import broken_off

from stretch_bt.errors import DeviceFault, DeviceLost
from stretch_bt.hardware.wire_thread import WireError, WireThread


class Counting:
    """A wire that counts; it raises the exception in `broken`, and `gate` holds it up."""

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
def begin(wire):
    made = []

    def make(deadline=5.0, period=0.002):
        thread = WireThread(
            "d",
            wire,
            period=period,
            deadline=deadline,
            now=time.monotonic,
            after_poll=lambda w, sample: None,
            at_loss=lambda w: w.said.append("last word"),
        )
        made.append(thread)
        thread.start()
        return thread

    yield make
    wire.gate.set()
    for thread in made:
        thread.end()
    assert not [t for t in threading.enumerate() if t.name.startswith("wire of")]


def until(ask):
    end = time.monotonic() + 20
    while time.monotonic() < end:
        if answer := ask():
            return answer
        time.sleep(0.002)
    raise AssertionError("it does not come")


def lost(thread):
    try:
        thread.latest()
    except DeviceLost as fault:
        return fault
    return None


def test_it_polls_and_runs_jobs_in_one_thread(begin, wire):
    thread = begin()
    first = thread.latest()
    until(lambda: thread.latest().number > first.number + 3)
    assert thread.do(lambda w: threading.current_thread().name) == "wire of d"
    before = wire.value
    assert before < thread.refresh().value <= wire.value  # it goes on polling
    thread.end()
    assert wire.said == ["connect", "close"]


@pytest.mark.parametrize("error", [WireError("cable"), ConnectionResetError("cable"), ValueError("cable")])
def test_a_wire_that_does_not_connect_leaves_nothing(begin, wire, error):
    wire.broken = error
    with pytest.raises(DeviceLost, match=r"d: it does not answer.*cable"):
        begin()


def test_a_client_that_is_missing_is_said_as_it_is(begin, wire):
    wire.broken = ImportError("install it")
    with pytest.raises(ImportError, match="install it"):
        begin()


def test_a_wire_that_hangs_at_first(begin, wire):
    wire.gate.clear()
    timer = threading.Timer(0.3, wire.gate.set)
    timer.start()
    with pytest.raises(DeviceLost, match=r"no answer within 0.05 s"):
        begin(deadline=0.05)
    timer.join()


def test_the_end_of_a_wire_that_hangs_says_which_device_and_where(begin, wire):
    thread = begin(deadline=0.3)
    wire.gate.clear()
    until(lambda: lost(thread))
    begun = time.monotonic()
    with pytest.raises(DeviceFault, match=r"d: .*hangs in .*test_wire_thread\.py:\d+ in read.*0\.3 s.*time limit"):
        thread.end()
    assert time.monotonic() - begun < 5.0
    wire.gate.set()
    thread.end()
    assert wire.said[-1] == "close"


def test_a_wire_that_does_not_answer_at_first_says_where_it_hangs(begin, wire):
    wire.gate.clear()
    with pytest.raises(DeviceLost, match=r"no answer within 0.05 s: it hangs in .*test_wire_thread\.py:\d+ in read"):
        begin(deadline=0.05)


class Speechless(Exception):
    def __str__(self):
        raise ValueError("cable")


@pytest.mark.parametrize("error", [WireError("cable"), BrokenPipeError("cable"), KeyError("cable"), Speechless()])
def test_a_loss_stays_also_where_the_wire_would_work_again(begin, wire, error):
    thread = begin()
    wire.broken = error
    until(lambda: lost(thread))
    wire.broken = None
    thread.wait_for_end()
    value = wire.value
    for _ in range(2):
        with pytest.raises(
            DeviceLost, match=r"d: the connection broke \(.*(cable|cannot be made).*\); start a new run"
        ):
            thread.latest()
        with pytest.raises(DeviceLost, match="start a new run"):
            thread.do(lambda w: 1)
    assert wire.value == value


def test_the_last_word_is_said_once_and_on_a_new_connection(begin, wire):
    thread = begin()

    def break_it(_):
        raise WireError("cable")

    with pytest.raises(DeviceLost, match="cable"):
        thread.do(break_it)
    thread.wait_for_end()
    assert wire.said == ["connect", "close", "connect", "last word", "close"]


def test_nothing_is_said_where_the_wire_does_not_connect_again(begin, wire):
    thread = begin()
    wire.broken = WireError("cable")
    until(lambda: lost(thread))
    thread.wait_for_end()
    assert wire.said == ["connect", "close", "connect", "close"]


def test_a_job_that_is_too_late_is_not_begun(begin, wire):
    thread = begin(deadline=0.2)
    wire.gate.clear()
    begun = []
    until(lambda: not wire.gate.is_set())
    time.sleep(0.02)
    with pytest.raises(DeviceLost, match=r"not answered within 0.2 s"):
        thread.do(begun.append)
    wire.gate.set()
    thread.wait_for_end()
    assert "not answered within 0.2 s" in str(lost(thread))
    assert begun == []
    assert wire.said[-2:] == ["last word", "close"]


def test_jobs_that_wait_as_the_wire_is_lost_are_refused_at_once(begin, wire):
    thread, refused, broken, cut = begin(deadline=30.0), [], threading.Event(), threading.Event()

    def ask(job):
        with pytest.raises(DeviceLost, match="cable") as raised:
            thread.do(job)
        refused.append(raised.value)

    def break_it(_):
        broken.set()
        cut.wait()
        raise WireError("cable")

    jobs = [break_it, *[lambda w: w.said.append("done")] * 3]
    asking = [threading.Thread(target=ask, args=(job,)) for job in jobs]
    asking[0].start()
    broken.wait()
    for one in asking[1:]:
        one.start()
    until(lambda: thread._jobs.qsize() == 3)
    cut.set()
    for one in asking:
        one.join(10.0)
    assert len(refused) == 4
    assert "done" not in wire.said


def test_a_job_that_breaks_the_wire_is_a_loss_and_one_that_refuses_is_not(begin, wire):
    thread = begin()

    def refuse(_):
        raise DeviceFault("d", "no")

    def break_it(_):
        raise OSError("cut")

    with pytest.raises(DeviceFault, match="d: no"):
        thread.do(refuse)
    assert lost(thread) is None
    with pytest.raises(DeviceLost, match="cut"):
        thread.do(break_it)
    assert "cut" in str(lost(thread))


def test_ctrl_c_before_the_first_reading_ends_the_thread(begin, wire):
    wire.gate.clear()
    with broken_off(lambda: wire.said):
        begin()
    wire.gate.set()
    until(lambda: "wire of d" not in [thread.name for thread in threading.enumerate()])
    assert wire.said == ["connect", "close"]
