"""Stand-ins for the controllers of a UR5 and a UR5e."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel
from stretch_bt.hardware.emulators.ur.client_port import ClientPort
from stretch_bt.hardware.emulators.ur.controller import Controller, ControllerModel
from stretch_bt.hardware.emulators.ur.dashboard import DashboardService
from stretch_bt.hardware.emulators.ur.force_noise import CB3, E_SERIES, ForceNoise, NoisyForce
from stretch_bt.hardware.emulators.ur.primary_messages import robot_state, version_message
from stretch_bt.hardware.emulators.ur.programs import Programs
from stretch_bt.hardware.emulators.ur.realtime_packet import realtime_packet
from stretch_bt.hardware.emulators.ur.rtde_server import STREAM_FAULTS, RtdeServer
from stretch_bt.hardware.transforms import inverse, pose_of, transform_of
from stretch_bt.hardware.ur.kinematics import MODELS

__all__ = ["BASE", "HAND", "Ur5StandIn", "Ur5eStandIn"]

#: the robot's base in the world, and the hand at its flange
BASE = Pose((-0.5, 0.0, 0.0))
HAND = Pose((0.0, 0.0, 0.3), (math.pi, 0.0, 0.0))
#: where the hand is at first, and joint angles near there
_HOME = Pose((0.0, 0.0, 0.2))
_NEAR = (math.pi, -1.6, 1.8, -1.8, -math.pi / 2, 0.0)

_MOVING = 1e-4
#: how often the primary and secondary ports send the state of the robot, Hz
_STATE_RATE = 10.0
#: names in faults for the connections of a wire
_CONNECTIONS = {"dashboard": "dashboard"}
#: stops that last as long as their fault; a protective stop is unlocked at the dashboard instead
_LASTING = ("emergency_stop", "safeguard_stop", "violation")

_FAULTS: dict[str, Fault] = {
    **STREAM_FAULTS,
    "protective_stop": Fault(
        "makes a protective stop, which can be unlocked after `locked` seconds; once", {"locked": 5.0}, state=True
    ),
    "emergency_stop": Fault("has its emergency stop button pressed, until it is cleared", state=True),
    "safeguard_stop": Fault("has its safeguard open, until it is cleared", state=True),
    "violation": Fault("reports a violation of its safety, until it is cleared", state=True),
    "program_stop": Fault("has its program stopped at the teach pendant; once", state=True),
    "power_off": Fault("has its power switched off; once", state=True),
    "home": Fault("has its hand brought back to where it was at first, at the teach pendant; once", state=True),
    "registers": Fault("has its input registers in use by another device", state=True),
    "local": Fault("is not in remote control: an e-series obeys no order of its dashboard", state=True),
    "no_solution": Fault("finds no joint angles for any pose, which ends the program that asks", state=True),
    "deaf": Fault("its program confirms commands, and does nothing of them", state=True),
    "stall": Fault("the arm stands, and the program goes on", state=True),
    "slider": Fault("has its speed slider at `fraction`", {"fraction": 0.1}, state=True),
    "frozen_force": Fault("sends the same force again and again, while time and place go on", state=True),
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
    """The controller of a UR5, PolyScope 3.15 at 125 Hz, half a metre from the object; it plays the script of ur_rtde, and a part of URScript."""

    PORTS: ClassVar[Mapping[str, int]] = {
        "rtde": 30004,
        "dashboard": 29999,
        "primary": 30001,
        "secondary": 30002,
        "realtime": 30003,
        "primary_read_only": 30011,
        "secondary_read_only": 30012,
        "realtime_read_only": 30013,
    }
    FAULTS: ClassVar[Mapping[str, Fault]] = _FAULTS
    SENSES: ClassVar[tuple[str, ...]] = ("felt",)
    MODEL: ClassVar[str] = "ur5"
    PROFILE: ClassVar[ControllerModel] = ControllerModel((3, 15, 8, 106339), 125.0, "UR5", "2018350000")
    NOISE: ClassVar[ForceNoise] = CB3

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        super().__init__(host, stage, ports)
        kinematics = MODELS[self.MODEL]
        flange = inverse(transform_of(BASE)) @ transform_of(_HOME) @ inverse(transform_of(HAND))
        self._home = kinematics.inverse(flange, _NEAR).tolist()
        self.arm = ArmModel(kinematics, self._home)
        self.controller = Controller(self.PROFILE, self.arm, self._felt, self.faults.shown)
        self._noise = NoisyForce(self.NOISE, stage.seed)
        self._latest: tuple[float, ...] = (0.0,) * 6
        self._moved = 0.0
        #: time of the latest fault, s of the controller, and how far the hand went since, m
        self._injected = self._way = 0.0
        self._place = _HOME.position
        self._servers: dict[str, TcpServer] = {}
        self._rtde: RtdeServer | None = None
        self._clients: dict[str, ClientPort] = {}
        self._programs = Programs(self.controller, self._tell_primary)
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> dict[str, str]:
        """Open the ports."""
        self._ending.clear()
        try:
            self._rtde = RtdeServer(self.host, self.ports["rtde"], self.controller, self.faults)
            self._servers["rtde"] = self._rtde.server
            dashboard = DashboardService(self.host, self.ports["dashboard"], self.controller, self.faults)
            self._servers["dashboard"] = dashboard.server
            for wire in [wire for wire in self.ports if wire not in self._servers]:
                self._clients[wire] = self._client_port(wire)
                self._servers[wire] = self._clients[wire].server
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
        servers, self._servers, self._clients = self._servers, {}, {}
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
                if wire != "rtde" and self.faults.meets(fault, connection=_CONNECTIONS.get(wire, "script")):
                    server.break_all(direction, reset=fault == "reset")

    def _client_port(self, wire: str) -> ClientPort:
        """Open one of the ports that send the state of the robot."""
        realtime = wire.startswith("realtime")
        return ClientPort(
            self.host,
            self.ports[wire],
            self.controller,
            self.faults,
            state=realtime_packet if realtime else robot_state,
            rate=self.PROFILE.rate if realtime else _STATE_RATE,
            greeting=None if realtime else version_message,
            load=None if wire.endswith("_read_only") else self._programs.load,
        )

    def hand(self) -> Pose:
        """Return where the hand is in the world, whatever tool is set in the controller."""
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
                for port in self._clients.values():
                    port.tell()

    def _note_hand(self) -> None:
        hand = self.hand()
        self._way += math.dist(hand.position, self._place)
        self._place = hand.position
        self.stage.place_hand(hand)

    def _felt(self) -> tuple[float, ...]:
        """Return the wrench on the tool in base axes, N and N m."""
        if self.faults.shown("frozen_force") is not None:
            return self._latest
        self._latest = self._estimate()
        return self._latest

    def _estimate(self) -> tuple[float, ...]:
        wrench = self.stage.wrench("Arm")
        felt = np.array([*wrench.force, *wrench.torque])
        load, wall = self.faults.shown("load"), self.faults.shown("wall")
        if load is not None:
            felt[:3] += [load["fx"], load["fy"], load["fz"]]
        if wall is not None:
            felt[2] += max(wall["height"] - self.hand().height, 0.0) * wall["stiffness"]
        turn = transform_of(BASE)[:3, :3].T
        return tuple((np.concatenate([turn @ felt[:3], turn @ felt[3:]]) + self._noise.error).tolist())

    def _tell_primary(self, message: Callable[[Controller], bytes]) -> None:
        """Send a message to all clients of the primary port; under the controller's lock."""
        for wire in ("primary", "primary_read_only"):
            if wire in self._clients:
                self._clients[wire].send(message)


class Ur5eStandIn(Ur5StandIn):
    """The controller of a UR5e, PolyScope 5.11 at 500 Hz; else like the controller of the UR5."""

    MODEL: ClassVar[str] = "ur5e"
    PROFILE: ClassVar[ControllerModel] = ControllerModel((5, 11, 8, 1010133), 500.0, "UR5", "20225500001")
    NOISE: ClassVar[ForceNoise] = E_SERIES
