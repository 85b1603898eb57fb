"""A person at the terminal."""

from __future__ import annotations

import os
import select
import sys
from typing import Literal

from stretch_bt.errors import DeviceFault, DeviceLost
from stretch_bt.hardware.driver import OperatorDriver, Options, Poll
from stretch_bt.hardware.indenters import described
from stretch_bt.hardware.interfaces import MotionState

__all__ = ["ConsoleOperator"]


class _Options(Options):
    type: Literal["Operator"]
    use: Literal["console"]


class ConsoleOperator(OperatorDriver):
    """Says on standard error what is to be done, and waits for Enter on standard input."""

    Options = _Options
    _asked = 0

    def open(self) -> None:
        """Make sure that somebody can answer."""
        if sys.stdin is None or not sys.stdin.isatty():
            raise DeviceFault(
                self.name,
                "standard input is no terminal, so that nobody can be asked; start the run in a terminal, or use another operator",
            )

    def stop(self) -> None:
        """Give up waiting."""
        self._asked += 1

    def mount(self, geometry: str, size: float) -> Poll:
        """Ask for an indenter."""
        return self._ask(f"Mount {described(geometry, size)} on the stand, centred under the hand, then press Enter.")

    def confirm(self, request: str) -> Poll:
        """Ask whether to go on."""
        return self._ask(f"{request} Press Enter to go on, Ctrl-C to end.")

    def _ask(self, text: str) -> Poll:
        """Return how it stands with a request; text that was typed before does not answer it."""
        self._asked += 1
        number = self._asked
        _forget_input()
        print(f"\n{self.name}: {text}", file=sys.stderr, flush=True)  # noqa: T201
        answered = False

        def poll() -> MotionState:
            nonlocal answered
            if self._asked == number and not answered:
                answered = self._answered()
            return (
                MotionState.DONE if answered else MotionState.MOVING if self._asked == number else MotionState.STOPPED
            )

        return poll

    def _answered(self) -> bool:
        """Return whether Enter was pressed, without waiting for it."""
        file = sys.stdin.fileno()
        if not select.select([file], [], [], 0.0)[0]:
            return False
        try:
            text = os.read(file, 4096)
        except OSError:  # a terminal that was closed
            text = b""
        if not text:
            raise DeviceLost(
                self.name, "the terminal was closed while the operator was asked; run again in an open one"
            )
        return b"\n" in text or b"\r" in text


def _forget_input() -> None:
    import termios

    termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)
