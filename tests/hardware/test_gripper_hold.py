"""A hold of the fingers that cannot be sent is reported, whatever ended their motion before."""

import pytest
from waiting import eventually

from stretch_bt.errors import DeviceFault, DeviceLost
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.robotiq.registers import ActivationStage, ObjectStatus, Status
from stretch_bt.hardware.wire_thread import WireError


class Wire:
    """Fingers on their way, to which no hold can be sent, on no new connection either."""

    exchanges = 1

    def __init__(self, blocked):
        self.going = self.dead = False
        self.blocked = blocked
        self.steps = 0

    def connect(self):
        self.check()

    def check(self):
        if self.dead:
            raise WireError("no route")

    def read(self):
        self.check()
        self.steps += self.going
        met = ObjectStatus.WHILE_CLOSING if self.blocked and self.steps > 3 else ObjectStatus.MOVING
        found = met if self.going else ObjectStatus.ARRIVED
        return Status(True, self.going, ActivationStage.ACTIVE, found, 0, 100, 100 + self.steps)

    def go(self, position, speed, force):
        self.going = True

    def hold(self, status):
        self.dead = True
        raise WireError("no answer")

    def reset(self):
        raise AssertionError("nothing was activated")

    activate = reset

    def close(self):
        pass


@pytest.fixture
def gripper(live_cell, clock, monkeypatch):
    """Return a function that opens a driver on such a wire."""

    def opened(blocked):
        spec = load_cell(live_cell("robotiq", "rtu", "127.0.0.1:9"))
        driver = spec.devices["gripper"].driver(
            CellContext(clock, 0, spec.path.parent, Hand(spec.hand), spec.limits.model_copy(update={"unwatched": 0.3}))
        )
        wire = Wire(blocked)
        monkeypatch.setattr(driver, "_wire", lambda: wire)
        driver.open()
        return driver, wire

    return opened


@pytest.mark.parametrize(
    ("blocked", "ended"),
    [(False, "no tick looked at the motion"), (True, "the connection broke")],
    ids=["hung", "blocked"],
)
def test_a_hold_that_cannot_be_sent_is_reported_also_where_the_motion_is_over(gripper, blocked, ended):
    driver, wire = gripper(blocked)
    poll = driver.move(driver.options.calibration.opening(100), 0.05)
    eventually(lambda: wire.dead or (blocked and poll() is None))
    with pytest.raises(DeviceLost, match="the connection broke"):
        driver.status()
    with pytest.raises(DeviceFault, match=ended):
        poll()
    with pytest.raises(DeviceLost, match="the fingers may go on"):
        driver.stop()
    driver.close()
