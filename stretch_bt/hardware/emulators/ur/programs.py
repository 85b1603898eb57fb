"""Programs that clients send: read, refused or run, and reported on the primary port."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.controller import Controller, Program
from stretch_bt.hardware.emulators.ur.primary_messages import key_message, runtime_exception, text_message
from stretch_bt.hardware.emulators.ur.script import ControlScript, parse_script
from stretch_bt.hardware.emulators.ur.urscript.check import check_names
from stretch_bt.hardware.emulators.ur.urscript.functions import FUNCTIONS
from stretch_bt.hardware.emulators.ur.urscript.interpreter import Interpreter
from stretch_bt.hardware.emulators.ur.urscript.moves import move_functions
from stretch_bt.hardware.emulators.ur.urscript.parse import parse
from stretch_bt.hardware.emulators.ur.urscript.robot import robot_functions
from stretch_bt.hardware.emulators.ur.urscript.syntax import Define
from stretch_bt.hardware.emulators.ur.urscript.tokens import ScriptFault

__all__ = ["Programs"]

#: how long a controller takes to load a program, s
_LOADING = 0.06
_CONTROL_SCRIPT = "rtde_control"
#: a program that runs beside another one
_SECONDARY = "sec"

Message = Callable[[Controller], bytes]


class Programs:
    """Takes the programs of one controller.

    Parameters
    ----------
    controller
        Controller that runs them.
    tell
        Sends a message to all clients of the primary port.
    """

    def __init__(self, controller: Controller, tell: Callable[[Message], None]) -> None:
        self._controller, self._tell = controller, tell
        self._functions: Mapping[str, Callable[..., Any]] = {**FUNCTIONS, **robot_functions(controller, self._say)}
        self._moves = move_functions(controller)

    def load(self, text: str) -> None:
        """Take a program: the control script of ur_rtde is played, another one is read; a program that cannot be read moves nothing."""
        with self._controller.lock:
            try:
                self._begin(text)
            except ScriptFault as fault:
                self._refuse(fault)

    def _begin(self, text: str) -> None:
        parsed = parse_script(text)
        if parsed is not None:
            script = ControlScript(self._controller, *parsed)
            self._controller.load(self._told(_CONTROL_SCRIPT, script.run()), _LOADING)
            return
        program = parse(text)
        if program.kind == _SECONDARY:
            self._run_beside(program)
            return
        functions = {**self._functions, **self._moves}
        check_names(program, functions)
        interpreter = Interpreter(self._controller, program, functions)
        self._controller.load(self._told(program.name, interpreter.run()), _LOADING)

    def _run_beside(self, program: Define) -> None:
        """Run a secondary program at once: it may not take time."""
        check_names(program, self._functions)
        line = self._controller.script_line
        next(Interpreter(self._controller, program, self._functions).run(), None)
        self._controller.script_line = line

    def _told(self, name: str, program: Program) -> Program:
        """Run a program, and report its begin, its end and its error."""
        self._event("STARTED", name)
        try:
            yield from program
        except IllConditioned as error:
            fault = error if isinstance(error, ScriptFault) else ScriptFault(str(error), 1)
            self._tell(lambda c: runtime_exception(c, fault.line, fault.column, fault.text))
            raise
        finally:
            self._event("STOPPED", name)

    def _event(self, what: str, name: str) -> None:
        self._tell(lambda c: key_message(c, f"PROGRAM_XXX_{what}", name))

    def _say(self, text: str) -> None:
        self._controller.note(f"the program says: {text[:200]}")
        self._tell(lambda c: text_message(c, text))

    def _refuse(self, fault: ScriptFault) -> None:
        self._controller.note(f"a program that is not understood was not run: {fault}"[:300])
        self._tell(lambda c: runtime_exception(c, fault.line, fault.column, fault.text))
