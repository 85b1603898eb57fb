"""Stand-ins for the controllers of a UR5 and a UR5e."""

from __future__ import annotations

import math
import socket
import threading
import time
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.stage import Stage
from stretch_bt.hardware.emulators.tcp_server import TcpServer, is_web, received
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel
from stretch_bt.hardware.emulators.ur.controller import Controller, Profile
from stretch_bt.hardware.emulators.ur.dashboard import Dashboard
from stretch_bt.hardware.emulators.ur.force_noise import CB3, E_SERIES, ForceNoise, NoisyForce
from stretch_bt.hardware.emulators.ur.rtde_server import STREAM_FAULTS, RtdeServer
from stretch_bt.hardware.emulators.ur.script import ControlScript, parse_script
from stretch_bt.hardware.transforms import inverse, pose_of, transform_of
from stretch_bt.hardware.ur.kinematics import MODELS

__all__ = ["BASE", "HAND", "Ur5StandIn", "Ur5eStandIn"]

#: the robot's base in the world, and the hand at its flange
BASE = Pose((-0.5, 0.0, 0.0))
HAND = Pose((0.0, 0.0, 0.3), (math.pi, 0.0, 0.0))
#: where the hand is at first, and joint angles near there
_HOME = Pose((0.0, 0.0, 0.2))
_NEAR = (math.pi, -1.6, 1.8, -1.8, -math.pi / 2, 0.0)

_LOADING = 0.06
_MOVING = 1e-4
_LONGEST_SCRIPT = 1 << 20
#: what faults call the connections of each wire
_CONNECTIONS = {"dashboard": "dashboard", "primary": "script", "secondary": "script", "realtime": "script"}
#: stops that last as long as their fault; a protective stop is unlocked at the dashboard instead
_LASTING = ("emergency_stop", "safeguard_stop", "violation")

_FAULTS: dict[str, Fault] = {
    **STREAM_FAULTS,
    "protective_stop": Fault(
        "makes a protective stop, which can be unlocked after `locked` seconds; once", {"locked": 5.0}, state=True
    ),
    "emergency_stop": Fault("has its emergency stop button pressed, until it is cleared", state=True),
    "safeguard_stop": Fault("has its safeguard open, until it is cleared", state=True),
    "violation": Fault("tells of a violation of its safety, until it is cleared", state=True),
    "program_stop": Fault("has its program stopped at the teach pendant; once", state=True),
    "power_off": Fault("has its power switched off; once", state=True),
    "home": Fault("has its hand brought back to where it was at first, at the teach pendant; once", state=True),
    "registers": Fault("has its input registers in use by another device", state=True),
    "local": Fault("is not in remote control", state=True),
    "no_solution": Fault("finds no joint angles for any pose, which ends the program that asks", state=True),
    "deaf": Fault("its program confirms commands, and does nothing of them", state=True),
    "stall": Fault("the arm stands, and the program goes on", state=True),
    "slider": Fault("has its speed slider at `fraction`", {"fraction": 0.1}, state=True),
    "load": Fault(
        "feels `fx`, `fy`, `fz` N in world axes besides what the scene does",
        {"fx": 0.0, "fy": 0.0, "fz": 0.0},
        state=True,
    ),
    "wall": Fault(
        "has a spring under the hand from `height` m on, of `stiffness` N/m",
        {"height": 0.1, "stiffness": 2000.0},
        state=True,
    ),
}


class Ur5StandIn(StandIn):
    """The controller of a UR5, PolyScope 3.15 at 125 Hz, half a metre from the object; it plays the script of ur_rtde and no other."""

    PORTS: ClassVar[Mapping[str, int]] = {
        "rtde": 30004,
        "dashboard": 29999,
        "primary": 30001,
        "secondary": 30002,
        "realtime": 30003,
    }
    FAULTS: ClassVar[Mapping[str, Fault]] = _FAULTS
    SENSES: ClassVar[tuple[str, ...]] = ("felt",)
    MODEL: ClassVar[str] = "ur5"
    PROFILE: ClassVar[Profile] = Profile((3, 15, 8, 106339), 125.0, "UR5", "2018350000")
    NOISE: ClassVar[ForceNoise] = CB3

    def __init__(self, host: str, stage: Stage, ports: Mapping[str, int] | None = None) -> None:
        super().__init__(host, stage, ports)
        kinematics = MODELS[self.MODEL]
        flange = inverse(transform_of(BASE)) @ transform_of(_HOME) @ inverse(transform_of(HAND))
        self._home = kinematics.inverse(flange, _NEAR).tolist()
        self.arm = ArmModel(kinematics, self._home)
        self.controller = Controller(self.PROFILE, self.arm, self._felt, self.faults.shown)
        self._noise = NoisyForce(self.NOISE, stage.seed)
        self._moved = 0.0
        #: time of the latest fault, s of the controller, and how far the hand went since, m
        self._injected = self._way = 0.0
        self._place = _HOME.position
        self._servers: dict[str, TcpServer] = {}
        self._rtde: RtdeServer | None = None
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> dict[str, str]:
        """Open the ports."""
        self._ending.clear()
        try:
            self._rtde = RtdeServer(self.host, self.ports["rtde"], self.controller, self.faults)
            self._servers["rtde"] = self._rtde.server
            dashboard = Dashboard(self.host, self.ports["dashboard"], self.controller, self.faults)
            self._servers["dashboard"] = dashboard.server
            for wire in ("primary", "secondary", "realtime"):
                self._servers[wire] = TcpServer(self.host, self.ports[wire], self._take_script, self._refuses)
        except BaseException:
            self.stop()
            raise
        self._note_hand()
        self._thread = threading.Thread(target=self._run, name="UR stand-in", daemon=True)
        self._thread.start()
        return {wire: "{}:{}".format(*server.address) for wire, server in self._servers.items()}

    def stop(self) -> None:
        """Close the ports."""
        self._ending.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.join()
        servers, self._servers = self._servers, {}
        for server in servers.values():
            server.stop()

    def state(self) -> dict[str, Any]:
        """Return how arm and controller stand."""
        with self.controller.lock:
            c = self.controller
            place = self.hand()
            return {
                "time": c.time,
                "moving": not self.arm.standing,
                "moved": self._moved,
                "injected": self._injected,
                "way": self._way,
                "running": c.running,
                "safety": c.safety.name,
                "x": place.position[0],
                "y": place.position[1],
                "height": place.height,
                "speed": float(np.linalg.norm(self.arm.tcp_speed[:3])),
                "force": math.hypot(*c.force()[:3]),
                "events": [f"{at:.3f} {event}" for at, event in c.events],
            }

    def inject(self, fault: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault."""
        super().inject(fault, parameters)
        with self.controller.lock:
            self._injected, self._way = self.controller.time, 0.0
            self._sever(fault)
            if fault in ("protective_stop", "emergency_stop", "safeguard_stop", "violation"):
                shown = self.faults.shown(fault) or {}
                self.controller.stop_safely(fault, "a fault was injected", shown.get("locked", 0.0))
            elif fault == "program_stop":
                self.controller.stop_program("stopped at the teach pendant")
            elif fault == "power_off":
                self.controller.power(on=False)
            elif fault == "home":
                self.controller.stop_program("the hand was moved at the teach pendant")
                self.arm.put(self._home)
                self._note_hand()
        if fault in ("reset", "close", "protective_stop", "program_stop", "power_off", "home"):
            self.clear(fault)

    def _sever(self, fault: str) -> None:
        """End the connections that a fault ends."""
        if fault == "drop":
            for server in self._servers.values():
                server.break_all()
        if fault in ("reset", "close"):
            direction = self.faults.chosen(fault).get("direction", "both")
            assert self._rtde is not None
            self._rtde.sever(fault)
            for wire, server in self._servers.items():
                if wire != "rtde" and self.faults.meets(fault, connection=_CONNECTIONS[wire]):
                    server.break_all(direction, reset=fault == "reset")

    def _refuses(self) -> bool:
        return self.faults.shown("drop") is not None

    def hand(self) -> Pose:
        """Return where the hand is in the world, whatever tool the controller was told of."""
        flange = self.arm.kinematics.forward(self.arm.q)
        return pose_of(transform_of(BASE) @ flange @ transform_of(HAND))

    def _run(self) -> None:
        """Do a cycle each period; where the machine is too busy for that, the controller's time goes slower."""
        period = 1 / self.PROFILE.rate
        due = time.monotonic()
        while not self._ending.wait(max(due - time.monotonic(), 0.0)):
            due = max(due + period, time.monotonic() - 5 * period)
            with self.controller.lock:
                for state in _LASTING:
                    if self.faults.shown(state) is None:
                        self.controller.release_stop(state)
                self._noise.draw(self.stage.force_noise("Arm"))
                self.controller.cycle()
                if not self.arm.steady:
                    self._note_hand()
                    if math.hypot(*self.arm.tcp_speed[:3]) > _MOVING:
                        self._moved = self.controller.time
                assert self._rtde is not None
                self._rtde.tell()

    def _note_hand(self) -> None:
        hand = self.hand()
        self._way += math.dist(hand.position, self._place)
        self._place = hand.position
        self.stage.place_hand(hand)

    def _felt(self) -> tuple[float, ...]:
        """Return the wrench on the tool in base axes, N and N m."""
        wrench = self.stage.wrench("Arm")
        felt = np.array([*wrench.force, *wrench.torque])
        load, wall = self.faults.shown("load"), self.faults.shown("wall")
        if load is not None:
            felt[:3] += [load["fx"], load["fy"], load["fz"]]
        if wall is not None:
            felt[2] += max(wall["height"] - self.hand().height, 0.0) * wall["stiffness"]
        turn = transform_of(BASE)[:3, :3].T
        return tuple((np.concatenate([turn @ felt[:3], turn @ felt[3:]]) + self._noise.error).tolist())

    def _take_script(self, connection: socket.socket) -> None:
        """Take programs; one that is not the control script of ur_rtde is noted, and not run."""
        text = b""
        for data in received(connection):
            if self.faults.meets("freeze", connection="script"):
                continue
            text += data
            if len(text) > _LONGEST_SCRIPT or is_web(text.partition(b"\n")[0]):
                return
            while b"\nend\n" in text:
                program, _, text = text.partition(b"\nend\n")
                self._load(program.decode("utf-8", "replace"))

    def _load(self, program: str) -> None:
        parsed = parse_script(program)
        with self.controller.lock:
            if parsed is None:
                self.controller.events.append((self.controller.time, "a program that is not understood was not run"))
                return
            self.controller.load(ControlScript(self.controller, *parsed).run(), _LOADING)


class Ur5eStandIn(Ur5StandIn):
    """The controller of a UR5e, PolyScope 5.11 at 500 Hz; else as that of the UR5."""

    MODEL: ClassVar[str] = "ur5e"
    PROFILE: ClassVar[Profile] = Profile((5, 11, 8, 1010133), 500.0, "UR5", "20225500001")
    NOISE: ClassVar[ForceNoise] = E_SERIES
