"""The dashboard of a controller, by a plain socket: every answer comes before a deadline, or OSError is raised."""

from __future__ import annotations

import socket
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Self

from stretch_bt.hardware.device_text import device_text

__all__ = ["PORT", "Dashboard", "ask_dashboard", "end_program"]

PORT = 29999
_LONGEST = 1024
_PAUSE = 0.01


class Dashboard:
    """A connection to a dashboard, which one line is asked at a time.

    Parameters
    ----------
    host
        Address of the controller.
    within
        How long connecting and all answers together may take, s.
    port
        Port of the dashboard.

    Raises
    ------
    OSError
        It cannot be reached, or does not greet in time.
    """

    def __init__(self, host: str, within: float, port: int = PORT) -> None:
        self._due = time.monotonic() + within
        self._rest = b""
        self._wire = socket.create_connection((host, port), timeout=self._left())
        try:
            self._line()  # it greets
        except BaseException:
            self._wire.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._wire.close()

    def ask(self, line: str) -> str:
        """Return the answer to a line; raises OSError when none comes in time."""
        self._wire.settimeout(self._left())
        self._wire.sendall(line.encode() + b"\n")
        return self._line()

    def _left(self) -> float:
        left = self._due - time.monotonic()
        if left <= 0:
            raise TimeoutError("the dashboard did not answer in time")
        return left

    def _line(self) -> str:
        while b"\n" not in self._rest:
            self._wire.settimeout(self._left())
            data = self._wire.recv(_LONGEST)
            if not data or len(self._rest) > _LONGEST:
                raise OSError("the dashboard closed the connection" if not data else "the dashboard sends no lines")
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\n")
        return device_text(line)


def ask_dashboard(host: str, asked: Sequence[str], within: float, port: int = PORT) -> list[str]:
    """Return the answers of a dashboard to some lines; raises OSError when one does not come in time."""
    with Dashboard(host, within, port) as dashboard:
        return [dashboard.ask(line) for line in asked]


def end_program(host: str, within: float) -> None:
    """End the program that a controller runs, and see that none runs.

    Raises
    ------
    OSError
        It cannot be seen that none runs; the text says why.
    """
    with Dashboard(host, within) as dashboard:
        answer = dashboard.ask("stop")
        try:
            while "false" not in dashboard.ask("running").lower():
                time.sleep(_PAUSE)
        except TimeoutError:
            raise OSError(f"it answered {answer!r} to `stop`, and its program runs on") from None
