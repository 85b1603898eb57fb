"""Stopping the control script on a controller from outside of the run that has it."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.ur.dashboard import ask_dashboard
from stretch_bt.hardware.ur.rtde import Rtde
from stretch_bt.hardware.ur.version import LOWER_ONLY, POLYSCOPE_X, TOO_NEW

if TYPE_CHECKING:
    from stretch_bt.hardware.ur.options import UrOptions

__all__ = ["halt"]

#: `runtime_state` while a program ends, and where there is none; any other one, paused too, goes on by itself or by the play button
_ENDED, _PLAYING = (0, 1), 2
#: speed of a joint, rad/s, under which the arm stands: a target, so that it has no noise
_STANDS = 1e-4
#: time within which a program that is stopped must have ended and the arm stand, s
_ENDING = 2.0
#: outputs of the control script while it waits for commands, and while it has done one
_READY, _DONE = 1, 2
#: command of the control script that asks for the place of the tool at the flange, and how long an answer may take, s
_ASK_TOOL, _ANSWERING = 40, 0.5
_PENDANT = "stop it at the pendant, or press the emergency stop"


@dataclass(frozen=True)
class _State:
    """How a controller stands: speed of the tool, m/s, whether a joint turns, state of the program, and what the script would write."""

    speed: float
    turns: bool
    program: int
    sign: int

    @property
    def running(self) -> bool:
        return self.program not in _ENDED

    @property
    def ended(self) -> bool:
        return not (self.running or self.turns)


def halt(name: str, options: UrOptions) -> Finding:
    """Stop the control script, beside a run too, and return what was found; a program of somebody else goes on.

    A control script is known by the registers of the cell file: a client writes its commands, or, where none is connected, it answers a
    question. What it wrote last is no sign of it: that stays when it has ended.
    """
    try:
        with Rtde(options.host) as controller:
            version = controller.version()
        if version[0] >= POLYSCOPE_X:
            return Finding(name, False, TOO_NEW, _PENDANT)
        first = 0 if options.registers == "lower" or version[:2] >= LOWER_ONLY else 24
        state = _state(options, first)
        if state.ended:
            return Finding(name, True, "no program runs on the controller, and the arm stands")
        if not state.running:
            return Finding(name, False, f"no program runs, and the arm moves at {1e3 * state.speed:.0f} mm/s", _PENDANT)
        client = _client(options, first) if state.sign in (_READY, _DONE) else None
        if client is None:
            program = ask_dashboard(options.host, ["programState"], _ENDING)[0]
            return Finding(name, False, f"{_stranger(state)} ({program}); it was not stopped", _PENDANT)
        begun = time.monotonic()
        answer = ask_dashboard(options.host, ["stop"], _ENDING)[0]
        while not (now := _state(options, first)).ended:
            if time.monotonic() > begun + _ENDING:
                return Finding(name, False, _goes_on(now, answer), _PENDANT)
        return Finding(name, True, _stopped(state, client, time.monotonic() - begun))
    except OSError as error:
        fix = "press the emergency stop where the arm moves; then check cable and address"
        return Finding(name, False, f"{options.host} does not answer ({error})", fix)


def _stranger(state: _State) -> str:
    if state.program == _PLAYING:
        return "a program that is not ours runs"
    return "a program is held, and no client that has it shows that it is ours"


def _stopped(before: _State, client: str, seconds: float) -> str:
    moved = f"the arm moved at {1e3 * before.speed:.0f} mm/s" if before.turns else "the arm stood"
    return f"our control script ran ({client}) and {moved}; stopped, and the arm stood within {seconds:.2f} s"


def _goes_on(now: _State, answer: str) -> str:
    what = "the program still runs" if now.running else f"the arm still moves at {1e3 * now.speed:.0f} mm/s"
    return f"{what}; the controller answered {answer!r} to stop"


def _state(options: UrOptions, first: int) -> _State:
    with Rtde(options.host) as controller:
        program, speed, turning, sign = controller.read(
            ["runtime_state", "target_TCP_speed", "target_qd", f"output_int_register_{first}"]
        )
    return _State(math.hypot(*speed[:3]), max(map(abs, turning)) > _STANDS, program, sign)


def _client(options: UrOptions, first: int) -> str | None:
    """Return who has the control script, None where the running program is no control script."""
    with Rtde(options.host) as controller:
        commands = controller.claim(f"input_int_register_{first}")
        if commands is None:
            return "a run that is open beside this has it"
        return "its client is gone" if _answers(controller, commands, first) else None


def _answers(controller: Rtde, commands: bytes, first: int) -> bool:
    """Return whether what runs takes a command that moves nothing, as the control script does; nobody else may write commands meanwhile."""
    for command, sign in ((0, _READY), (_ASK_TOOL, _DONE), (0, _READY)):
        controller.write(commands, command)
        due = time.monotonic() + _ANSWERING
        while controller.read([f"output_int_register_{first}"]) != [sign]:
            if time.monotonic() > due:
                controller.write(commands, 0)
                return False
    return True
