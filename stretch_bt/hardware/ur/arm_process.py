"""The process of an arm, as its driver sees it, and what is left on the controller after it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from stretch_bt.frames import Pose
from stretch_bt.hardware.messages import Message
from stretch_bt.hardware.supervisor import Deadlines, ProcessProgram, Supervisor
from stretch_bt.hardware.ur.dashboard import end_program
from stretch_bt.hardware.ur.messages import (
    CODEC,
    ArmState,
    Beat,
    ControllerSettings,
    Engage,
    Engaged,
    Feel,
    Follow,
    Guard,
    Guarded,
    Left,
    MeanWrench,
    Six,
    Stop,
    Zero,
)
from stretch_bt.hardware.wire_thread import Sample

__all__ = ["ArmProcess"]

_MODULE = "stretch_bt.hardware.ur.process"
#: how long the process may be silent, s: more than the controller may be while it works; while it connects; while it makes ready to move
_MORE, _CONNECTING, _ENGAGING = 0.2, 5.0, 11.0
#: how long it may take to end; to answer that the arm stands; to take a mean of the force more than that lasts
_ENDING, _STOPPING, _FEELING = 1.5, 1.0, 1.0
#: how long the dashboard may take to end the program after a loss, s
_FAREWELL = 0.3


class ArmProcess:
    """Keeps one process that keeps one arm.

    After a loss, and wherever the process did not say that it ended its program, the program is ended at the dashboard, on a connection of
    this process. A program of somebody else is never ended: ours is one that was begun while none ran, and that was not seen to end.

    Parameters
    ----------
    name
        The device, for messages.
    settings
        What the process goes by.
    now
        The clock of the run, s.
    contact_height
        Returns the world height of first contact, m, once it is known.
    """

    def __init__(
        self,
        name: str,
        settings: ControllerSettings,
        now: Callable[[], float],
        contact_height: Callable[[], float | None],
    ) -> None:
        self._settings, self._now, self._contact_height = settings, now, contact_height
        self._watched = 0.0
        self._sample: Sample[ArmState] | None = None
        self._read = 0
        #: whether our program may run on the controller, and whether the process still has to say that it began
        self._ours = self._beginning = False
        #: whether the dashboard was asked after the process, and why it cannot be seen that our program ended
        self._asked, self._unseen = False, ""
        self.supervisor = Supervisor(
            name,
            ProcessProgram(_MODULE, CODEC, [settings]),
            Deadlines(_CONNECTING, settings.lost_after + _MORE, _ENDING),
            take=self._take,
            beat=lambda: Beat(self._contact_height(), self._watched),
            after=self._end_program,
            remark=self._about_program,
        )

    def latest(self) -> Sample[ArmState]:
        """Return the latest state; raises DeviceLost once the process was lost."""
        self.supervisor.check_connected()
        assert self._sample is not None
        return self._sample

    def watch(self) -> None:
        """Take note that whoever leads the arm looks at its motion now."""
        self._watched = time.monotonic()

    def engage(self) -> str | None:
        """Have the arm made ready to move, and return what keeps it from that; raises DeviceLost."""
        self._beginning = self._ours = not self.latest().value.program
        answer = self.supervisor.ask(Engage(self.supervisor.number()), _ENGAGING, quiet=True)
        assert isinstance(answer, Engaged)
        self._ours = self._ours and answer.begun  # a program that began since we looked is somebody else's
        self._beginning = False
        return answer.reason

    def feel(self, over: float) -> MeanWrench:
        """Return the mean of the controller's wrenches over a time, s; raises DeviceLost."""
        answer = self.supervisor.ask(Feel(self.supervisor.number(), over), over + _FEELING)
        assert isinstance(answer, MeanWrench)
        return answer

    def zero(self, wrench: Six) -> None:
        """Take a wrench off all that follow, and return when the latest state is without it; raises DeviceLost."""
        self.supervisor.ask(Zero(self.supervisor.number(), wrench), self._settings.lost_after + _STOPPING)

    def guard(self) -> str | None:
        """Have the limits held, and return which one is passed already; raises DeviceLost."""
        answer = self.supervisor.ask(Guard(self.supervisor.number()), _STOPPING)
        assert isinstance(answer, Guarded)
        return answer.reason

    def follow(self, path: Sequence[Pose], speed: float) -> int:
        """Have the hand led through poses, and return the number of the motion; raises DeviceLost."""
        number = self.supervisor.number()
        self.supervisor.send(Follow(number, tuple((*pose.position, *pose.rotation) for pose in path), speed))
        return number

    def stop(self) -> None:
        """Brake, and return when the arm stands; raises DeviceLost."""
        self.supervisor.ask(Stop(self.supervisor.number()), _STOPPING)

    def unseen_program(self) -> str | None:
        """Return, after a loss, that it cannot be seen that our program ended; None where it can."""
        self.supervisor.wait_for_end()
        return self._about_program() if self._unseen else None

    def _take(self, message: Message) -> bool:
        if isinstance(message, Left):
            self._ours = self._ours and message.program
        if not isinstance(message, ArmState):
            return False
        self._read += 1
        self._sample = Sample(message, self._now(), self._read)
        if not self._beginning:
            self._ours = self._ours and message.program
        return True

    def _end_program(self) -> None:
        """End our program, where it may run still."""
        try:
            if self._ours:
                end_program(self._settings.host, _FAREWELL)
                self._ours = False
        except OSError as error:
            self._unseen = str(error)
        finally:
            self._asked = True

    def _about_program(self) -> str:
        """Return what is known of our program on the controller."""
        if not self._ours:
            return "no program of this run is left on the controller"
        watchdog = f"its watchdog ends it within {1 / self._settings.watchdog:.2g} s"
        if not self._asked:
            return f"its program is being ended, and {watchdog}"
        return f"it cannot be seen that its program ended ({self._unseen}); {watchdog}: look at the pendant"
