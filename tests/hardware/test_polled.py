"""A driver whose device one thread polls: its connection is its own, and what it says last stops the device."""

import threading
import time

import pytest

from stretch_bt.devices import DeviceFault, DeviceLost, GripperDriver, MotionState, Options, PolledDriver
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.implementations import Unusable, _checked


class Fingers:
    """A connection that writes down what is said over it; `garbled` answers cannot be read, and `gate` holds it up."""

    def __init__(self):
        self.said = []
        self.garbled = False
        self.gate = threading.Event()
        self.gate.set()

    def connect(self):
        self.said.append("connect")

    def read(self):
        self.gate.wait()
        if self.garbled:
            return {}["opening"]
        return 0.055

    def close(self):
        self.said.append("close")


class Polled(PolledDriver, GripperDriver):
    """A gripper on such a connection."""

    rate = 200.0

    def wire(self):
        return Fingers()

    def move(self, opening, speed):
        begun = self.command(lambda wire: wire.said.append("go"))
        return lambda: MotionState.MOVING if self.since(begun) is None else MotionState.DONE

    def halt(self, wire):
        wire.said.append("halt")

    def opening(self):
        sample = self.latest()
        return sample.reading(sample.value)


@pytest.fixture
def made(tmp_path):
    """Make drivers, and close them at the end."""
    drivers = []

    def make(cls=Polled):
        spec = load_cell("simulated")
        cell = CellContext(time.monotonic, 0, tmp_path, Hand(spec.hand), spec.limits)
        drivers.append(cls("gripper", Options(), cell))
        return drivers[-1]

    yield make
    for driver in drivers:
        driver.close()
    left = [t for t in threading.enumerate() if t.name.startswith("wire of")]
    for thread in left:  # one that hung ends once its device answers
        thread.join(10)
    assert not any(thread.is_alive() for thread in left)


def wire_of(driver):
    return driver.do(lambda wire: wire)


def until_lost(driver):
    end = time.monotonic() + 20
    while time.monotonic() < end:
        try:
            driver.latest()
        except DeviceLost as lost:
            return lost
        time.sleep(0.002)
    raise AssertionError("it is not lost")


def test_two_devices_of_one_driver_have_a_connection_each(made):
    one, other = made(), made()
    one.open()
    other.open()
    assert wire_of(one) is not wire_of(other)


def test_a_driver_keeps_its_connection_and_connects_it_anew(made):
    driver = made()
    driver.open()
    wire = wire_of(driver)
    driver.close()
    driver.open()
    assert wire_of(driver) is wire
    assert wire.said == ["connect", "close", "connect"]


def test_a_garbled_answer_halts_what_moves_on_a_new_connection(made):
    driver = made()
    driver.open()
    wire = wire_of(driver)
    driver.move(0.06, 0.05)
    wire.garbled = True
    assert "KeyError: 'opening'" in str(until_lost(driver))
    driver._thread.wait_for_end()
    assert wire.said == ["connect", "go", "close", "connect", "halt", "close"]


def test_a_connection_that_hangs_is_told_as_the_device_is_closed_and_is_not_used_again(made):
    class Hasty(Polled):
        deadline = 0.2

    driver = made(Hasty)
    driver.open()
    wire = wire_of(driver)
    wire.gate.clear()
    until_lost(driver)
    with pytest.raises(DeviceFault, match=r"gripper: .*hangs in .*test_polled\.py:\d+ in read"):
        driver.close()
    driver.open()
    assert wire_of(driver) is not wire
    wire.gate.set()


def test_a_driver_that_moves_and_could_not_stop_is_none():
    """It passed every check, and no safe stop reached its device."""

    class Unstoppable(PolledDriver, GripperDriver):
        """Fingers that go on."""

        def wire(self):
            return Fingers()

        def move(self, opening, speed):
            return lambda: MotionState.DONE

        def opening(self):
            return self.latest().reading(0.055)

    with pytest.raises(Unusable, match="the driver Unstoppable lacks halt"):
        _checked(Unstoppable)
    assert _checked(Polled) is Polled


@pytest.mark.parametrize("given", [None, 5])
def test_a_driver_that_makes_no_connection_is_told(made, given):
    class Unwired(Polled):
        def wire(self):
            return given

    with pytest.raises(DeviceFault, match=rf"gripper: Unwired.wire\(\) gave {given}, which has no connect\(\); let it"):
        made(Unwired).open()
