"""The dashboard: one line asked, one line answered, in the words of the maker's guide to "Dashboard server".

The stand-in keeps no program files, so none can be loaded; `play` goes on with a program that was paused.
"""

from __future__ import annotations

import socket
from collections.abc import Callable

from stretch_bt.hardware.emulators.faults import Faults
from stretch_bt.hardware.emulators.tcp_server import TcpServer, lines
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.ur.version import has_model

__all__ = ["DashboardService"]

_LONGEST = 2048
_MODES = {3: "POWER_OFF", 4: "POWER_ON", 5: "IDLE", 7: "RUNNING"}
_STATES = {1: "STOPPED", 2: "PLAYING", 4: "PAUSED"}
_ROLES = ("PROGRAMMER", "OPERATOR", "NONE", "LOCKED", "RESTRICTED")
_NOTED = 200
#: what an e-series does in remote control only: whatever changes the arm, its program or its safety
_REMOTE = (
    *("load", "play", "stop", "pause", "shutdown", "power on", "power off", "brake release", "unlock protective stop"),
    *("close safety popup", "load installation", "restart safety", "set operational mode", "clear operational mode"),
)
_LOCAL = "Command is not allowed due to safety reasons, please switch robot to Remote Control mode and reconnect to port 29999"
_TOO_SOON = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop before unlocking"
)


class DashboardService:
    """Answers the lines of one controller's dashboard."""

    def __init__(self, host: str, port: int, controller: Controller, faults: Faults) -> None:
        self._controller, self._faults = controller, faults
        self._mode, self._role = "NONE", "PROGRAMMER"
        c = controller
        self._answers: dict[str, Callable[[], str]] = {
            "polyscopeversion": self._version,
            "get serial number": lambda: c.profile.serial,
            "robotmode": lambda: f"Robotmode: {_MODES[c.robot_mode]}",
            "safetymode": lambda: f"Safetymode: {c.safety.name}",
            "running": lambda: f"Program running: {str(c.running).lower()}",
            "programstate": lambda: f"{_STATES[c.runtime_state]} <unnamed>",
            "get loaded program": lambda: "No program loaded",
            "isprogramsaved": lambda: "false <unnamed>",
            "stop": self._stop,
            "play": lambda: "Starting program" if c.resume() else "Failed to execute: play",
            "pause": lambda: "Pausing program" if c.pause() else "Failed to execute: pause",
            "power on": lambda: self._power("Powering on", on=True),
            "power off": lambda: self._power("Powering off", on=False),
            "shutdown": lambda: self._power("Shutting down", on=False),
            "quit": lambda: "Disconnected",
            "brake release": self._release_brakes,
            "unlock protective stop": lambda: "Protective stop releasing" if c.unlock() else _TOO_SOON,
            "close safety popup": lambda: "closing safety popup",
            "close popup": lambda: "closing popup",
            "restart safety": lambda: "Restarting safety",
            **({"get robot model": lambda: c.profile.model} if has_model(c.profile.version[:2]) else {}),
            **(self._newer() if c.profile.e_series else {"getuserrole": lambda: self._role}),
        }
        #: commands with words behind them
        self._worded: dict[str, Callable[[str], str]] = {
            "load installation": lambda name: f"File not found: {name}",
            "load": lambda name: f"File not found: {name}",
            "popup": lambda text: self._noted("a popup says", text, "showing popup"),
            "addtolog": lambda text: self._noted("log", text, "Added log message"),
            "generate flight report": lambda kind: "Error: a stand-in makes no reports",
            "generate support file": lambda path: "Error: a stand-in makes no support files",
            **({"set operational mode": self._set_mode} if c.profile.e_series else {"setuserrole": self._set_role}),
        }
        self.server = TcpServer(host, port, self._serve, lambda: faults.shown("drop") is not None)

    def _newer(self) -> dict[str, Callable[[], str]]:
        """Return the commands that only an e-series has."""
        c = self._controller
        return {
            "version": lambda: ".".join(map(str, c.profile.version)),
            "is in remote control": lambda: str(not self._is_local()).lower(),
            "safetystatus": lambda: f"Safetystatus: {c.safety.name}",
            "get operational mode": lambda: self._mode,
            "clear operational mode": self._clear_mode,
        }

    def _is_local(self) -> bool:
        """Whether it takes no orders; a CB3 knows no such mode."""
        return self._controller.profile.e_series and self._faults.shown("local") is not None

    def answer(self, line: bytes) -> str:
        """Return the answer to a line, whatever it holds."""
        asked = line.decode("utf-8", "replace").strip()
        if self._is_local() and any(f"{asked.lower()} ".startswith(f"{command} ") for command in _REMOTE):
            return _LOCAL
        with self._controller.lock:
            found = self._answers.get(asked.lower())
            if found is not None:
                return found()
            for command, worded in self._worded.items():
                if asked.lower().startswith(f"{command} "):
                    return worded(asked[len(command) :].strip())
        return f'could not understand: "{asked[:60]}"'

    def _serve(self, connection: socket.socket) -> None:
        connection.sendall(b"Connected: Universal Robots Dashboard Server\n")
        for line in lines(connection, _LONGEST):
            if self._faults.meets("freeze", connection="dashboard"):
                continue
            connection.sendall(self.answer(line).encode() + b"\n")
            if line.strip().lower() == b"quit" or (line.strip().lower() == b"shutdown" and not self._is_local()):
                return

    def _noted(self, what: str, text: str, said: str) -> str:
        self._controller.note(f"{what}: {text[:_NOTED]}")
        return said

    def _set_mode(self, mode: str) -> str:
        if mode.upper() not in ("MANUAL", "AUTOMATIC"):
            return f"Failed setting operational mode: {mode}"
        self._mode = mode.upper()
        return f"Operational mode {self._mode} is set"

    def _clear_mode(self) -> str:
        self._mode = "NONE"
        return "No longer controlling the operational mode. Current operational mode: 'NONE'."

    def _set_role(self, role: str) -> str:
        if role.upper() not in _ROLES:
            return f"Failed setting user role: {role}"
        self._role = role.upper()
        return f"Setting user role: {self._role}"

    def _version(self) -> str:
        return "URSoftware {}.{}.{}.{} (stand-in)".format(*self._controller.profile.version)

    def _stop(self) -> str:
        self._controller.stop_program("stopped by the dashboard")
        return "Stopped"

    def _power(self, said: str, *, on: bool) -> str:
        self._controller.power(on=on)
        return said

    def _release_brakes(self) -> str:
        self._controller.release_brakes()
        return "Brake releasing"
