"""What every stand-in has."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from stretch_bt.hardware.emulators.faults import Fault, Faults
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld

__all__ = ["StandIn"]


class StandIn(ABC):
    """A device that is not there, on a loopback address: constructed it does nothing, started it serves in threads.

    Parameters
    ----------
    host
        Address that it listens on.
    stage
        What stands around it: fingers, hand and object, shared with other stand-ins.
    ports
        Ports by the name of the wire, where they differ from `PORTS`; 0 takes a free one.
    """

    #: ports that it listens on, by the name of the wire
    PORTS: ClassVar[Mapping[str, int]]
    FAULTS: ClassVar[Mapping[str, Fault]]
    #: parts of a scene that it needs: "felt" for forces, "seen" for images
    SENSES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        self.host = host
        self.stage = stage
        self.ports = {**self.PORTS, **(ports or {})}
        self.faults = Faults(self.FAULTS)

    def activated(self) -> None:  # noqa: B027  most devices need none
        """Begin as a device that somebody made ready to move before; nothing to do unless a stand-in says so."""

    @abstractmethod
    def start(self) -> dict[str, str]:
        """Begin to serve, and return where each wire is; raises OSError when an address cannot be had."""

    @abstractmethod
    def stop(self) -> None:
        """End all threads and close all ports; may be called more than once."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Return how the device stands, for whoever looks from outside: plain numbers by name."""

    def inject(self, fault: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault."""
        self.faults.inject(fault, parameters)

    def clear(self, fault: str | None = None) -> None:
        """End a fault, or all of them."""
        self.faults.clear(fault)

    def active(self) -> list[str]:
        """Return the names of the faults that are shown now."""
        return self.faults.active()
