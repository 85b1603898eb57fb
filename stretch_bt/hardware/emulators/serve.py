"""Some stand-ins around one stage, with or without a control port, in this process or in one of their own."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.control import ControlPort
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.stage import Stage

__all__ = ["Served", "Servers", "serving", "serving_elsewhere"]

_READY = 30.0


@dataclass(frozen=True)
class Served:
    """Where the wires of each stand-in are, by name, and the control port, if any."""

    wires: dict[str, dict[str, str]]
    control: tuple[str, int] | None = None

    def to_json(self) -> dict[str, Any]:
        """Return it for a line of JSON."""
        return {"wires": self.wires, "control": self.control and list(self.control)}


@dataclass(frozen=True)
class Servers:
    """What is served."""

    stand_ins: dict[str, StandIn]
    served: Served


@contextmanager
def serving(
    names: Sequence[str],
    stage: Stage,
    *,
    host: str = "127.0.0.1",
    control: int | None = None,
    ports: Mapping[str, Mapping[str, int]] | None = None,
    activated: bool = False,
) -> Iterator[Servers]:
    """Serve stand-ins in threads of this process, until the context is left.

    Parameters
    ----------
    names
        Names of the registry.
    stage
        What they share.
    host
        Address that all listen on, the control port too.
    control
        Port on which faults are injected, 0 for a free one; none is opened for None.
    ports
        Ports of a stand-in by the name of its wire, where they are not its own.
    activated
        Whether devices that need an activation had it before.

    Raises
    ------
    OSError
        A port cannot be had; nothing stays open.
    """
    twice = sorted({name for name in names if list(names).count(name) > 1})
    if twice or not names:
        raise InvalidInput(f"name each stand-in once, not {', '.join(names) or 'none'}")
    with ExitStack() as stack:
        stand_ins, wires = {}, {}
        for name in names:
            made = stand_in_class(name)(host, stage, (ports or {}).get(name))
            if activated:
                made.activated()
            stack.callback(made.stop)
            wires[name] = made.start()
            stand_ins[name] = made
        address = None
        if control is not None:
            port = ControlPort((host, control), stand_ins, wires)
            stack.callback(port.stop)
            address = port.address
        yield Servers(stand_ins, Served(wires, address))


@contextmanager
def serving_elsewhere(names: Sequence[str], *options: str, within: float = _READY) -> Iterator[Served]:
    """Serve stand-ins in a process of their own, by `stretch-bt emulate`, until the context is left.

    The process ends with its standard input, so that none is left when this one is killed.

    Parameters
    ----------
    names
        Names of the registry.
    *options
        Options of the command, such as `"--control", "0"`.
    within
        Time until they must be ready, s.

    Raises
    ------
    InvalidInput
        The process ended, or was not ready in time; with what it said.
    """
    command = [sys.executable, "-m", "stretch_bt.cli", "emulate", *names, *options, "--with-input", "--json"]
    process = subprocess.Popen(  # noqa: S603  the arguments are our own command
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ}
    )
    try:
        yield _ready(process, time.monotonic() + within)
    finally:
        _end(process)


def _ready(process: subprocess.Popen[bytes], deadline: float) -> Served:
    """Return what the process says once it serves."""
    assert process.stdout is not None
    assert process.stderr is not None
    text = b""
    while not text.endswith(b"\n"):
        if not select.select([process.stdout], [], [], max(deadline - time.monotonic(), 0.0))[0]:
            raise InvalidInput("the stand-ins were not ready in time")
        data = os.read(process.stdout.fileno(), 4096)
        if not data:
            raise InvalidInput(f"the stand-ins ended: {process.stderr.read().decode('utf-8', 'replace').strip()}")
        text += data
    said = json.loads(text)
    return Served(said["wires"], said["control"] and (said["control"][0], said["control"][1]))


def _end(process: subprocess.Popen[bytes]) -> None:
    assert process.stdin is not None
    process.stdin.close()
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()
