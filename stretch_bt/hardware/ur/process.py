"""The process that has the clients of ur_rtde: a crash, a hang or a reconnect of theirs ends it, and nothing else.

It reads the arm in every cycle, lets `Control` decide, and does what that says. It ends when the run is gone, or as a connection to the
controller is lost; one that hangs is ended by its own alarm.
"""

from __future__ import annotations

import math
import signal
import sys
import threading
import time

from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.keeper import keep
from stretch_bt.hardware.messages import Message
from stretch_bt.hardware.ur.control import Control
from stretch_bt.hardware.ur.cycle import Brake, Command, GiveUp, Inputs, Kick, Leave, MakeReady, Say, Servo
from stretch_bt.hardware.ur.lifelines import Lifelines
from stretch_bt.hardware.ur.messages import CODEC, ControllerSettings, Engaged, Left
from stretch_bt.hardware.ur.session import ArmRefused, Session

__all__ = ["ArmKeeper"]

RTDE = 30004
#: how long one cycle, connecting, and making ready may take before the process is ended, s
_STUCK, _CONNECTING, _ENGAGING = 2.0, 4.0, 10.0
#: a cycle that is later than this, s, was not given its time by the machine
_LATE = 0.05


class ArmKeeper:
    """Keeps one arm.

    Parameters
    ----------
    channel
        Channel to the driver.
    first
        Messages that came already, the first of them `ControllerSettings`.
    """

    def __init__(self, channel: Channel, first: list[Message]) -> None:
        settings, *self._came = first
        assert isinstance(settings, ControllerSettings)
        self._channel, self._period = channel, 1 / settings.rate
        self._session = Session(settings, Lifelines(RTDE, settings.lost_after))
        self._control = Control(settings)
        self._braking: threading.Thread | None = None
        #: results of the commands of the cycle before
        self._engaged: Engaged | None = None
        self._taken = True

    def run(self) -> None:
        """Go on until the driver or the controller is gone."""
        state = self._control.begin(time.monotonic())
        due = woke = time.monotonic()
        while True:
            signal.setitimer(signal.ITIMER_REAL, _STUCK)
            woke, late = time.monotonic(), time.monotonic() - woke - self._period
            inputs = self._inputs(state.measured.time if state.measured else -math.inf, late)
            state, commands = self._control.step(state, time.monotonic(), inputs)
            for command in commands:
                self._do(command)
            due = max(due + self._period, time.monotonic() - _LATE)
            time.sleep(max(due - time.monotonic(), 0.0))

    def end(self, *, lost: bool) -> None:
        """Brake, end the control script, and say whether a program runs still; nothing is asked of a controller that is lost."""
        if lost:
            return
        signal.setitimer(signal.ITIMER_REAL, _STUCK)
        self._brake()
        self._wait_for_brake()
        self._channel.send(Left(self._session.leave()))

    def _inputs(self, after: float, late: float) -> Inputs:
        came, self._came = (*self._came, *self._channel.drain()), []
        engaged, self._engaged = self._engaged, None
        taken, self._taken = self._taken, True
        return Inputs(
            measured=self._session.measure(after),
            messages=came,
            braking=self._braking is not None and self._braking.is_alive(),
            engaged=engaged,
            taken=taken,
            late=late if late > _LATE else 0.0,
        )

    def _do(self, command: Command) -> None:
        match command:
            case Say(message):
                self._channel.send(message)
            case Servo(hand):
                self._taken = self._session.servo(hand)
            case Kick():
                self._session.kick()
            case Brake():
                self._brake()
            case MakeReady(number):
                self._engaged = Engaged(number, self._make_ready(), self._session.begun)
            case Leave():
                raise ChannelClosed("asked to end")
            case GiveUp(reason):
                raise OSError(reason)

    def _brake(self) -> None:
        """Begin to brake, in a thread because the client waits until the arm stands."""
        self._wait_for_brake()
        self._braking = threading.Thread(target=self._session.brake, daemon=True)
        self._braking.start()

    def _wait_for_brake(self) -> None:
        if self._braking is not None:
            self._braking.join()

    def _make_ready(self) -> str | None:
        """Make the arm ready to move, and return what keeps it from that."""
        signal.setitimer(signal.ITIMER_REAL, _ENGAGING)
        try:
            self._session.engage()
        except ArmRefused as refused:
            return str(refused)
        return None


if __name__ == "__main__":
    keep(
        int(sys.argv[1]),
        CODEC,
        ArmKeeper,
        opening=_CONNECTING,
        package="ur-rtde ({}); install it with: pip install ur-rtde",
    )
