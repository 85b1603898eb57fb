"""The dashboard: one line asked, one line answered."""

from __future__ import annotations

import socket
from collections.abc import Callable

from stretch_bt.hardware.emulators.faults import Faults
from stretch_bt.hardware.emulators.tcp_server import TcpServer, lines
from stretch_bt.hardware.emulators.ur.controller import Controller

__all__ = ["Dashboard"]

_LONGEST = 2048
_MODES = {3: "POWER_OFF", 4: "POWER_ON", 5: "IDLE", 7: "RUNNING"}
_TOO_SOON = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop before unlocking"
)


class Dashboard:
    """Answers the lines of one controller's dashboard."""

    def __init__(self, host: str, port: int, controller: Controller, faults: Faults) -> None:
        self._controller, self._faults = controller, faults
        c = controller
        self._answers: dict[str, Callable[[], str]] = {
            "polyscopeversion": self._version,
            "get robot model": lambda: c.profile.model,
            "get serial number": lambda: c.profile.serial,
            "is in remote control": lambda: str(faults.shown("local") is None).lower(),
            "robotmode": lambda: f"Robotmode: {_MODES[c.robot_mode]}",
            "safetymode": lambda: f"Safetymode: {c.safety.name}",
            "safetystatus": lambda: f"Safetystatus: {c.safety.name}",
            "running": lambda: f"Program running: {str(c.running).lower()}",
            "programstate": lambda: f"{'PLAYING' if c.running else 'STOPPED'} <unnamed>",
            "get loaded program": lambda: "No program loaded",
            "isprogramsaved": lambda: "False <unnamed>",
            "stop": self._stop,
            "play": lambda: "Failed to execute: play",
            "pause": lambda: "Failed to execute: pause",
            "power on": lambda: self._power("Powering on", on=True),
            "power off": lambda: self._power("Powering off", on=False),
            "brake release": self._release_brakes,
            "unlock protective stop": lambda: "Protective stop releasing" if c.unlock() else _TOO_SOON,
            "close safety popup": lambda: "closing safety popup",
            "close popup": lambda: "closing popup",
            "restart safety": lambda: "Restarting safety",
        }
        if not c.profile.e_series:
            for name in ("get serial number", "is in remote control", "safetystatus"):
                del self._answers[name]
        self.server = TcpServer(host, port, self._serve, lambda: faults.shown("drop") is not None)

    def answer(self, line: bytes) -> str:
        """Return the answer to a line, whatever it holds."""
        asked = line.decode("utf-8", "replace").strip()
        if asked.lower().startswith(("popup ", "addtolog ")):
            return "showing popup" if asked.lower().startswith("popup") else "Added log message"
        with self._controller.lock:
            found = self._answers.get(asked.lower())
            return found() if found is not None else f'could not understand: "{asked[:60]}"'

    def _serve(self, connection: socket.socket) -> None:
        connection.sendall(b"Connected: Universal Robots Dashboard Server\n")
        for line in lines(connection, _LONGEST):
            if self._faults.meets("freeze", connection="dashboard"):
                continue
            if line.strip().lower() in (b"quit", b"shutdown"):
                connection.sendall(b"Disconnected\n")
                return
            connection.sendall(self.answer(line).encode() + b"\n")

    def _version(self) -> str:
        return "URSoftware {}.{}.{}.{} (stand-in)".format(*self._controller.profile.version)

    def _stop(self) -> str:
        if self._controller.profile.e_series and self._faults.shown("local") is not None:
            return "Failed to execute: stop"
        self._controller.stop_program("stopped by the dashboard")
        return "Stopped"

    def _power(self, said: str, *, on: bool) -> str:
        self._controller.power(on=on)
        return said

    def _release_brakes(self) -> str:
        self._controller.release_brakes()
        return "Brake releasing"
