"""A stand-in for an ATI sensor that streams by RDT, and answers commands and for its page."""

from __future__ import annotations

import socket
import threading
import time
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, ClassVar

import numpy as np

from stretch_bt.hardware.ati.rdt import PORT, Ask, Record, parse_request
from stretch_bt.hardware.emulators.ati_services import COMMANDS, PAGE, serve_commands, serve_page
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer, cannot_listen

__all__ = ["AtiStandIn"]

_PER_NEWTON = _PER_NEWTON_METRE = 1_000_000
_RATE = 125.0
_MODULUS = 1 << 32
_MOST = (1 << 31) - 1
_NOISE = 0.002
#: records in a packet of a buffered stream
_TOGETHER = 10

_FAULTS: dict[str, Fault] = {
    "silence": Fault("sends nothing, and hears nothing", state=True),
    "loss": Fault("loses the part `part` of its packets", {"part": 0.3}),
    "reorder": Fault("exchanges the part `part` of its packets with the one after", {"part": 0.3}),
    "repeat": Fault("sends every packet twice"),
    "freeze": Fault("sends, but measures nothing new: its cycle number and counts stand"),
    "frozen_force": Fault("sends the same counts again and again, while its cycle number goes on"),
    "late": Fault("sends each packet `delay` seconds after it was measured", {"delay": 0.3}, state=True),
    "wild": Fault("sends random counts in the part `part` of its packets", {"part": 0.02}),
    "status": Fault(
        "sends the status word `code`; from 0x80000000 on the sensor calls it an error", {"code": 0x80000002}
    ),
    "short": Fault("sends half of each packet"),
    "noise": Fault("sends packets of random bytes, of the right length"),
    "restart": Fault("begins its numbers anew, as after a loss of its supply; once"),
    "slow": Fault("sends at `rate` packets a second", {"rate": 5.0}, state=True),
    "load": Fault(
        "feels `fx`, `fy`, `fz` N besides what the scene does", {"fx": 0.0, "fy": 0.0, "fz": 0.0}, state=True
    ),
    "drift": Fault("drifts along z by `rate` N a second", {"rate": 0.1}, state=True),
}


class AtiStandIn(StandIn):
    """An Axia80 under the object, its axes along the world's: 125 records a second, 1 000 000 counts a newton and newton metre."""

    PORTS: ClassVar[Mapping[str, int]] = {"commands": COMMANDS, "page": PAGE, "rdt": PORT}
    FAULTS: ClassVar[Mapping[str, Fault]] = _FAULTS
    SENSES: ClassVar[tuple[str, ...]] = ("felt",)
    per_unit = (_PER_NEWTON, _PER_NEWTON_METRE)
    settings: ClassVar[Mapping[str, str]] = {
        "prodname": "Stand-in of an Axia80",
        "setcfgsel": "0",
        "comrdte": "Enabled",
        "comrdtrate": f"{_RATE:.0f}",
        "comrdtbsiz": str(_TOGETHER),
        "runrate": f"{_RATE:.0f}",
    }

    def __init__(self, host: str, stage: StandInWorld, ports: Mapping[str, int] | None = None) -> None:
        chosen = dict(ports or {})
        beside = dict.fromkeys(("commands", "page"), 0) if chosen.get("rdt") == 0 else {}
        super().__init__(host, stage, {**beside, **chosen})  # where the stream has a free port, so have the others
        self._random = np.random.default_rng(stage.seed)
        self._ending, self._restarting = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self._client: tuple[str, int] | None = None
        self._left, self._together = 0, 1
        self._gathered: list[bytes] = []
        self._servers: list[TcpServer] = []
        #: lock of the measurements, and of the bias
        self._sensing = threading.RLock()
        self._number = self._cycle = self._sent = 0
        self._bias = np.zeros(6)
        self._kept: bytes | None = None
        self._delayed: deque[tuple[float, bytes]] = deque()
        self._frozen: tuple[int, tuple[int, ...]] | None = None
        self._drifting: float | None = None

    def start(self) -> dict[str, str]:
        """Open the ports."""
        try:
            places = self._serve()
            self._socket = self._bound()
        except BaseException:
            self.stop()
            raise
        self._ending.clear()
        self._thread = threading.Thread(target=self._run, name="RDT stand-in", daemon=True)
        self._thread.start()
        host, port = self._socket.getsockname()
        return {**places, "rdt": f"{host}:{port}"}

    def _serve(self) -> dict[str, str]:
        places = {}
        for wire, serve in (("commands", serve_commands), ("page", serve_page)):
            server = TcpServer(self.host, self.ports[wire], lambda c, serve=serve: serve(c, self))  # type: ignore[misc]
            self._servers.append(server)
            places[wire] = f"{server.address[0]}:{server.address[1]}"
        return places

    def _bound(self) -> socket.socket:
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            made.bind((self.host, self.ports["rdt"]))
        except OSError as error:
            made.close()
            raise cannot_listen(self.host, self.ports["rdt"], error) from error
        return made

    def stop(self) -> None:
        """Close the ports."""
        self._ending.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.join()
            self._socket.close()
        servers, self._servers = self._servers, []
        for server in servers:
            server.stop()

    def counts(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Return the six counts of now, (6,), since the last bias."""
        with self._sensing:
            counts: np.ndarray[Any, np.dtype[np.float64]] = self._measured() - self._bias
            return counts

    def bias(self) -> None:
        """Take what is felt now as zero."""
        with self._sensing:
            self._bias = self._measured()

    def status(self) -> int:
        """Return the status word that is shown."""
        shown = self.faults.shown("status")
        return int(shown["code"]) % _MODULUS if shown else 0

    def silent(self) -> bool:
        """Whether it hears and says nothing."""
        return self.faults.shown("silence") is not None

    def state(self) -> dict[str, Any]:
        """Return how many records went out, and whether a client has a stream."""
        return {"sent": self._sent, "streaming": self._client is not None}

    def inject(self, fault: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault."""
        super().inject(fault, parameters)
        if fault == "restart":
            self.clear(fault)
            self._restarting.set()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._ending.is_set():
            self._socket.settimeout(max(due - time.monotonic(), 1e-4))
            with suppress(TimeoutError, OSError):
                self._hear(*self._socket.recvfrom(2048))
            now = time.monotonic()
            if now >= due:
                slow = self.faults.shown("slow")
                due = max(due + 1 / (slow["rate"] if slow else _RATE), now)
                if self._client is not None:
                    self._send_one(self._client)

    def _hear(self, data: bytes, sender: tuple[str, int]) -> None:
        asked = parse_request(data)
        if asked is None or self.silent():
            return
        command, count = asked
        if command in (Ask.STREAM, Ask.BUFFERED):
            self._client, self._left, self._number = sender, count, 0
            self._together, self._gathered = _TOGETHER if command == Ask.BUFFERED else 1, []
        elif command == Ask.STOP:
            self._client = None
        elif command == Ask.BIAS:
            self.bias()

    def _send_one(self, client: tuple[str, int]) -> None:
        if self._restarting.is_set():
            self._restarting.clear()
            self._number = self._cycle = 0
            self._bias = np.zeros(6)
        self._cycle = (self._cycle + 1) % _MODULUS
        self._number = (self._number + 1) % _MODULUS
        if not self.silent():
            for packet in self._due(self._packets(self._block())):
                self._socket.sendto(packet, client)
                self._sent += 1
        self._left -= 1
        if self._left == 0:
            self._client = None

    def _block(self) -> bytes:
        """Return the records of a packet once it is full, or the last one of a stream; nothing before."""
        self._gathered.append(self._record().encode())
        if len(self._gathered) < self._together and self._left != 1:
            return b""
        gathered, self._gathered = self._gathered, []
        return b"".join(gathered)

    def _record(self) -> Record:
        counts = self.counts()
        clipped = np.clip(np.round(counts), -_MOST, _MOST).astype(int).tolist()
        frozen, stands = self.faults.take("freeze"), self.faults.take("frozen_force")
        if frozen is None and stands is None:
            self._frozen = None
        else:
            self._frozen = self._frozen or (self._cycle, tuple(clipped))
            clipped = list(self._frozen[1])
        cycle = self._cycle if frozen is None or self._frozen is None else self._frozen[0]
        wild = self.faults.take("wild")
        if wild is not None and self._random.random() < wild["part"]:
            clipped = self._random.integers(-_MOST, _MOST, 6).tolist()
        status = self.faults.take("status")
        return Record(self._number, cycle, int(status["code"]) % _MODULUS if status else 0, tuple(clipped))

    def _due(self, packets: list[bytes]) -> list[bytes]:
        """Return what is sent now of all that was measured."""
        now, late = time.monotonic(), self.faults.shown("late")
        self._delayed.extend((now + (late["delay"] if late else 0.0), packet) for packet in packets)
        return [self._delayed.popleft()[1] for _ in range(len(self._delayed)) if self._delayed[0][0] <= now]

    def _packets(self, data: bytes) -> list[bytes]:
        """Return what goes out in place of a packet."""
        if not data:
            return []
        for fault, broken in (("short", data[:18]), ("noise", self._random.bytes(36))):
            if self.faults.take(fault) is not None:
                return [broken]
        loss, swap = self.faults.take("loss"), self.faults.take("reorder")
        if loss is not None and self._random.random() < loss["part"]:
            return []
        if self._kept is not None:
            kept, self._kept = self._kept, None
            return [data, kept]
        if swap is not None and self._random.random() < swap["part"]:
            self._kept = data
            return []
        return [data, data] if self.faults.take("repeat") is not None else [data]

    def _measured(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Return counts of what the hand does to the sensor under the object: the reverse of what it feels."""
        wrench = self.stage.wrench("ForceSensor")
        load, drift = self.faults.shown("load"), self.faults.shown("drift")
        felt = -np.array([*wrench.force, *wrench.torque])
        if load is not None:
            felt[:3] += [load["fx"], load["fy"], load["fz"]]
        self._drifting = None if drift is None else (self._drifting or time.monotonic())
        if drift is not None and self._drifting is not None:
            felt[2] += drift["rate"] * (time.monotonic() - self._drifting)
        sd = self.stage.force_noise("ForceSensor")
        felt[:3] += self._random.normal(0.0, _NOISE if sd is None else sd, 3)
        counts: np.ndarray[Any, np.dtype[np.float64]] = felt * np.repeat([_PER_NEWTON, _PER_NEWTON_METRE], 3)
        return counts
