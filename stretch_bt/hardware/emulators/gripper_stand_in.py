"""What the stand-ins for a gripper share, whatever the protocol."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.gripper_model import GripperModel
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer

__all__ = ["GripperStandIn"]


class GripperStandIn(StandIn):
    """A gripper behind TCP ports, which faults reach."""

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        super().__init__(host, stage, ports)
        self.model = GripperModel(stage, self.faults.shown)
        #: lock of the model
        self.lock = threading.RLock()
        self._servers: list[TcpServer] = []

    def refuses(self) -> bool:
        """Whether new connections are closed at once."""
        return self.faults.shown("drop") is not None

    def activated(self) -> None:
        """Stand as after an activation."""
        self.model.activated()

    def stop(self) -> None:
        """Close the ports."""
        servers, self._servers = self._servers, []
        for server in servers:
            server.stop()

    def state(self) -> dict[str, Any]:
        """Return how the fingers stand."""
        with self.lock:
            return self.model.state()

    def inject(self, fault: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault."""
        super().inject(fault, parameters)
        with self.lock:
            if fault == "deactivate":
                self.clear(fault)
                self.model.lose_activation()
            self.model.changed()
        for server in self._servers:
            if fault in ("drop", "reset"):
                server.break_all(reset=fault == "reset")
        if fault == "reset":
            self.clear(fault)

    def clear(self, fault: str | None = None) -> None:
        """End a fault, or all of them."""
        super().clear(fault)
        with self.lock:
            self.model.changed()
