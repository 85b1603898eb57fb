"""The clients of ur_rtde, in the process that they have to themselves."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, cast

from stretch_bt.hardware.motion.path import LEVER
from stretch_bt.hardware.transforms import inverse, six, transform
from stretch_bt.hardware.ur.dashboard import ask_dashboard
from stretch_bt.hardware.ur.guard import MeasuredState
from stretch_bt.hardware.ur.kinematics import MODELS
from stretch_bt.hardware.ur.lifelines import Lifelines
from stretch_bt.hardware.ur.messages import ControllerSettings, Six
from stretch_bt.hardware.ur.version import LOWER_ONLY, TOO_NEW, is_polyscope_x, major_minor

if TYPE_CHECKING:
    from rtde_control import RTDEControlInterface
    from rtde_receive import RTDEReceiveInterface

__all__ = ["ArmRefused", "Session"]

_VARIABLES = [
    "timestamp",
    "actual_q",
    "actual_qd",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_TCP_force",
    "robot_mode",
    "robot_status_bits",
    "safety_status_bits",
]
_RUNNING = 7
_PROGRAM = 1 << 1
_STARTING, _SETTLING, _ENDING, _ANSWERING = 3.0, 1.0, 0.2, 2.0
#: how many times as soon as the watchdog the arm stands: nothing feeds it while the client waits for that
_SOONER = 1.5
#: how far the tool may be from where nominal kinematics have it, m; a robot's own calibration is millimetres
_UNLIKE = 0.02


class ArmRefused(Exception):
    """The controller or its state keeps the arm from being moved; the text says what to do."""


class Session:
    """A controller that is read from the begin, and can be made ready to move.

    Parameters
    ----------
    settings
        What to connect to, and how.
    lifelines
        What watches the connections.

    Raises
    ------
    OSError, RuntimeError
        The controller cannot be reached.
    """

    def __init__(self, settings: ControllerSettings, lifelines: Lifelines) -> None:
        from rtde_receive import RTDEReceiveInterface

        self._settings, self._lifelines = settings, lifelines
        self._version = _version(settings.host)
        self._receive: RTDEReceiveInterface = RTDEReceiveInterface(settings.host, settings.rate, _VARIABLES)
        lifelines.hold("reads")
        self._control: RTDEControlInterface | None = None
        #: whether a program of ours may have been begun
        self.begun = False

    def measure(self, after: float) -> MeasuredState | None:
        """Return the latest measurement, unless its time is `after`, s of the controller; raises OSError once the connection is lost."""
        receive = self._receive
        if not receive.isConnected():
            raise OSError("the controller closed the connection")
        time = receive.getTimestamp()
        while time != after:
            measured = MeasuredState(
                time,
                _six(receive.getActualQ()),
                _six(receive.getActualTCPPose()),
                _six(receive.getActualTCPSpeed()),
                _six(receive.getActualTCPForce()),
                receive.getRobotMode(),
                self.program_runs,
                receive.getSafetyStatusBits(),
            )
            before, time = time, receive.getTimestamp()
            if time == before:  # else a package came meanwhile, and the values are of two
                return measured
        return None

    @property
    def program_runs(self) -> bool:
        """Whether the controller runs a program."""
        return bool(self._receive.getRobotStatus() & _PROGRAM)

    def engage(self) -> None:
        """Make ready to move: run the control script, set tool, payload and watchdog; moves nothing, and ends no program.

        Raises
        ------
        ArmRefused
            With why, and what to do.
        """
        if self._receive.isProtectiveStopped():
            raise ArmRefused(
                "protective stop: look for its cause, move the hand clear if need be, wait 5 s, and unlock it at the pendant"
            )
        mode = self._receive.getRobotMode()
        if mode != _RUNNING:
            raise ArmRefused(f"the robot is not running (mode {mode}); switch power and brakes on at the pendant")
        self._run_script()
        self._configure()

    def servo(self, target: Six) -> bool:
        """Send the hand's next place in the base; return whether the script takes it."""
        s = self._settings
        assert self._control is not None
        return bool(self._control.servoL(list(target), 0.0, 0.0, 1 / s.rate, s.lookahead, s.gain))

    def brake(self) -> None:
        """Come to rest, before the watchdog takes the silence for a loss."""
        if self._control is not None and self.program_runs:
            fastest = max(map(abs, self._receive.getActualQd()))
            self._control.servoStop(max(self._settings.stop_acceleration, _SOONER * fastest * self._settings.watchdog))

    def kick(self) -> None:
        """Feed the watchdog."""
        if self._control is not None and self.program_runs:
            self._control.kickWatchdog()

    def leave(self) -> bool:
        """End the control script, and return whether the controller runs a program still."""
        if self._control is not None and self.program_runs:
            with suppress(RuntimeError):
                self._control.stopScript()
            _until(lambda: not self.program_runs, _ENDING)
        return self.program_runs

    def _run_script(self) -> None:
        from rtde_control import RTDEControlInterface

        if self.program_runs:
            raise ArmRefused("the controller runs a program, which is not ended for this; stop it at the pendant")
        upper = RTDEControlInterface.FLAG_UPPER_RANGE_REGISTERS if self._takes_upper() else 0
        flags = RTDEControlInterface.FLAG_UPLOAD_SCRIPT | upper
        self.begun = True
        try:
            self._control = RTDEControlInterface(self._settings.host, self._settings.rate, flags)
        except Exception as error:  # what it throws depends on the controller: all of it means that it cannot be had
            raise ArmRefused(f"the controller cannot be had ({error})") from error
        self._lifelines.hold("controls")
        self._lifelines.forbid_more()
        if not _until(lambda: self.program_runs, _STARTING):
            raise ArmRefused("the control script does not run on the controller; look at the pendant")

    def _takes_upper(self) -> bool:
        """Return whether to take the upper registers: from PolyScope 5.23 on ur-rtde 1.6 uses the lower ones, but its script the upper ones."""
        return self._settings.upper_registers and self._version < LOWER_ONLY

    def _configure(self) -> None:
        assert self._control is not None
        s, control = self._settings, self._control
        done = control.setTcp(list(s.hand)) and control.setWatchdog(s.watchdog)
        if s.payload is not None:
            done = done and control.setPayload(s.payload[0], list(s.payload[1:]))
        if not done:
            raise ArmRefused("the control script does not take commands; look at the pendant")
        _until(lambda: self._apart() < _UNLIKE, _SETTLING)
        if self._apart() >= _UNLIKE:
            raise ArmRefused(
                f"the tool is {1e3 * self._apart():.0f} mm from where a {s.model} has it at these joint angles; "
                "`model` or `hand` of the cell file do not fit this robot"
            )

    def _apart(self) -> float:
        """Return how far the tool is from where the nominal kinematics have it, m."""
        flange = transform(self._receive.getActualTCPPose()) @ inverse(transform(self._settings.hand))
        nominal = MODELS[self._settings.model].forward(self._receive.getActualQ())
        off = six(inverse(nominal) @ flange)
        return max(math.hypot(*off[:3]), LEVER * math.hypot(*off[3:]))


def _version(host: str) -> tuple[int, ...]:
    """Return major and minor version of a controller; raises OSError where it does not answer, or is not supported."""
    try:
        (answer,) = ask_dashboard(host, ["PolyscopeVersion"], _ANSWERING)
    except OSError as error:
        if isinstance(error, ConnectionRefusedError) and is_polyscope_x(host):
            raise OSError(TOO_NEW) from error
        raise
    return major_minor(answer)


def _until(ask: Callable[[], bool], seconds: float) -> bool:
    end = time.monotonic() + seconds
    while not ask():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


def _six(values: Sequence[float]) -> Six:
    return cast(Six, tuple(values))
