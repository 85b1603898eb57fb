"""Some stand-ins, with or without a control port: in threads of this process, or each in a process of its own around one scene."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.control import ControlPort
from stretch_bt.hardware.emulators.messages import TWIN, Renew, Serve, Serving, Solve
from stretch_bt.hardware.emulators.pictures import picture_memory
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.remote import Process, RemoteStandIn
from stretch_bt.hardware.emulators.setting import Setting
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld

__all__ = ["Served", "Servers", "free_ports", "serving", "serving_elsewhere"]

_READY = 60.0
_TWIN = "stretch_bt.hardware.emulators.twin_process"
Ports = Mapping[str, Mapping[str, int]]


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
    """What is served, and the processes that do it, if they are not threads of this one."""

    stand_ins: Mapping[str, StandIn | RemoteStandIn]
    served: Served
    processes: Sequence[Process] = field(default=())

    twin: Process | None = None

    def renew(self) -> None:
        """Put a new object, as it was at first, in the place of the present one; raises InvalidInput without a scene, or while the hand touches."""
        _renew(self.twin)

    def check(self) -> None:
        """Raise InvalidInput, with the reason, when a process has ended."""
        for process in self.processes:
            process.check()


@contextmanager
def serving(
    names: Sequence[str],
    stage: StandInWorld,
    *,
    host: str = "127.0.0.1",
    control: int | None = None,
    ports: Ports | None = None,
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
    _check_names(names)
    with ExitStack() as stack:
        stand_ins, wires = {}, {}
        for name in names:
            made = stand_in_class(name)(host, stage, (ports or {}).get(name))
            if activated:
                made.activated()
            stack.callback(made.stop)
            wires[name] = made.start()
            stand_ins[name] = made
        yield Servers(stand_ins, Served(wires, _controlled(stack, host, control, stand_ins, wires)))


@contextmanager
def serving_elsewhere(
    names: Sequence[str],
    *,
    scene: str | None = None,
    seed: int = 0,
    host: str = "127.0.0.2",
    control: int | None = None,
    ports: Ports | None = None,
    activated: bool = False,
    within: float = _READY,
) -> Iterator[Servers]:
    """Serve stand-ins, each in a process of its own, until the context is left; none outlives this process.

    Parameters
    ----------
    names, host, control, ports, activated
        As for `serving`.
    scene
        File or name of the scene that they act on; its twin has a process too.
    seed
        Seed of everything random.
    within
        Time until they must be ready, s.

    Raises
    ------
    InvalidInput
        One of them cannot be had, with the reason; none is left.
    """
    _check_names(names)
    with ExitStack() as stack:
        begun = time.monotonic()
        setting = None if scene is None else Setting(scene, seed, begun)
        twin, ways = (None, {}) if setting is None else _twin(stack, names, setting)
        stand_ins = {}
        for name in names:
            own = dict((ports or {}).get(name, {}))
            first = Serve(name, host, own, activated, seed, setting)
            stand_ins[name] = RemoteStandIn(first, ways.get(name, ()))
            stack.callback(stand_ins[name].end)
        processes = [*([twin] if twin is not None else []), *stand_ins.values()]
        said = {process.name: process.answer(begun + within - time.monotonic()) for process in processes}
        wires = {name: answer.wires for name, answer in said.items() if isinstance(answer, Serving)}
        port = _controlled(stack, host, control, stand_ins, wires, lambda: _renew(twin))
        yield Servers(stand_ins, Served(wires, port), processes, twin)


def free_ports(names: Sequence[str]) -> dict[str, dict[str, int]]:
    """Return ports of stand-ins that let each take a free one."""
    return {name: dict.fromkeys(stand_in_class(name).PORTS, 0) for name in names}


def _renew(twin: Process | None) -> None:
    if twin is None:
        raise InvalidInput("nothing is in the place of an object; name a scene with --scene")
    twin.ask(Renew())


def _twin(stack: ExitStack, names: Sequence[str], setting: Setting) -> tuple[Process, dict[str, list[int]]]:
    """Begin the process of the twin, and return it with what the process of each stand-in inherits to reach it."""
    memory = stack.enter_context(os.fdopen(picture_memory(), "rb")).fileno()
    ends = [[stack.enter_context(end).fileno() for end in socket.socketpair()] for _ in names]
    first = Solve(setting, [list(stand_in_class(name).SENSES) for name in names])
    twin = Process("the twin", _TWIN, TWIN, first, [memory, *(end for end, _ in ends)])
    stack.callback(twin.end)
    return twin, {name: [memory, end] for name, (_, end) in zip(names, ends, strict=True)}


def _check_names(names: Sequence[str]) -> None:
    if not names or len(set(names)) < len(names):
        raise InvalidInput(f"name each stand-in once, not {', '.join(names) or 'none'}")
    for name in names:
        stand_in_class(name)


def _controlled(
    stack: ExitStack,
    host: str,
    control: int | None,
    stand_ins: Mapping[str, StandIn | RemoteStandIn],
    wires: Mapping[str, Mapping[str, str]],
    renew: Callable[[], None] = lambda: _renew(None),
) -> tuple[str, int] | None:
    """Open the control port where one is asked for, and return its address."""
    if control is None:
        return None
    port = ControlPort((host, control), stand_ins, wires, renew)
    stack.callback(port.stop)
    return port.address
