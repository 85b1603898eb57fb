"""The gripper behind pymodbus's own simulator server: its registers move as the fingers would."""

from __future__ import annotations

import asyncio
import threading
import time
from typing import Any

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from stretch_bt_modbus_gripper import registers as r


class Fingers:
    """Fingers that go to a target at a constant speed, m and m/s."""

    def __init__(self, opening: float = 0.055) -> None:
        self._from = self._to = opening
        self._speed, self._begun, self._held = 1.0, 0.0, False

    def go(self, target: float, speed: float) -> None:
        """Begin a motion."""
        self._from, self._to, self._speed, self._begun, self._held = (
            self.opening,
            target,
            speed,
            time.monotonic(),
            False,
        )

    def hold(self) -> None:
        """Stay here."""
        self._held = self._held or self.opening != self._to
        self._from = self._to = self.opening

    @property
    def opening(self) -> float:
        """Where they are."""
        way = self._to - self._from
        gone = self._speed * (time.monotonic() - self._begun)
        return self._to if gone >= abs(way) else self._from + (gone if way > 0 else -gone)

    @property
    def state(self) -> int:
        """What the gripper says of it."""
        return r.HELD if self._held else r.ARRIVED if self.opening == self._to else r.MOVING


class Simulator:
    """Serves the registers on a free port of loopback until it is stopped."""

    def __init__(self) -> None:
        self.port = 0
        self.fingers = Fingers()
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="two jaw simulator", daemon=True)
        self._thread.start()
        self._ready.wait(10)

    def stop(self) -> None:
        """Close the port and every connection; may be called more than once."""
        if self._thread.is_alive():
            asyncio.run_coroutine_threadsafe(self._server.shutdown(), self._loop).result(5)
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(5)

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._listen())
        self._ready.set()
        self._loop.run_forever()
        self._loop.close()

    async def _listen(self) -> None:
        registers = SimData(0, count=r.REGISTERS, values=0, datatype=DataType.REGISTERS)
        device = SimDevice(1, simdata=[registers], action=self._access)
        self._server = ModbusTcpServer(device, address=("127.0.0.1", 0))
        await self._server.serve_forever(background=True)
        self.port = self._server.transport.sockets[0].getsockname()[1]

    async def _access(
        self, function: int, start: int, address: int, count: int, now: list[int], written: list[Any] | None
    ) -> ExcCodes | None:
        """Bring the registers up to date before they are read, and do what is written."""
        if written is None:
            now[r.OPENING - start] = round(self.fingers.opening / r.COUNT)
            now[r.STATE - start] = self.fingers.state
        elif address == r.TARGET and count >= 3:
            self.fingers.go(written[0] * r.COUNT, written[1] * r.SPEED_COUNT)
        elif address == r.COMMAND:
            self.fingers.hold()
        return None
