"""One client of RTDE: the values that it receives, the inputs that it may set."""

from __future__ import annotations

import socket
import struct
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.variables import Ask
from stretch_bt.hardware.emulators.ur.wire import flat, layout, package

__all__ = ["RtdeSession"]

#: the number of the one output recipe, which only the second protocol sends
_RECIPE = b"\x01"


@dataclass(eq=False)
class RtdeSession:
    """One client: its connection, its recipes, and how far it is."""

    connection: socket.socket
    #: version of the protocol; a client that does not ask for another has the first
    protocol: int = 1
    every: int = 1
    asks: Sequence[Ask] = ()
    inputs: dict[int, list[str]] = field(default_factory=dict)
    started: bool = False
    cycle: int = 0
    due: float = 0.0
    held: deque[tuple[float, bytes]] = field(default_factory=deque)
    last: bytes = b""
    deaf: bool = False
    _layout: struct.Struct = field(default_factory=lambda: struct.Struct(">"))

    @property
    def kind(self) -> str:
        """What the client does: it controls where it has inputs."""
        return "control" if self.inputs else "receive"

    def tell(self, types: Sequence[str], asks: Sequence[Ask], every: int) -> None:
        """Take the recipe of the values that it receives, once in so many cycles."""
        self._layout, self.asks, self.every = struct.Struct(layout(types)), asks, every

    def data(self, controller: Controller) -> bytes:
        """Return the package with the present values of its recipe."""
        values = self._layout.pack(*flat([ask(controller) for ask in self.asks]))
        return package("U", values if self.protocol == 1 else _RECIPE + values)
