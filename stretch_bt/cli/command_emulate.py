"""`stretch-bt emulate`."""

from __future__ import annotations

import ipaddress
import os
import select
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import emit_json, warn
from stretch_bt.errors import InvalidInput

if TYPE_CHECKING:
    from stretch_bt.hardware.emulators.serve import Servers

__all__ = ["command"]


def command(
    devices: Annotated[
        list[str], typer.Argument(help="Which, such as ur, robotiq, ati, realsense; several share one scene.")
    ],
    host: Annotated[str, typer.Option("--host", help="Address to listen on.")] = "127.0.0.2",
    scene: Annotated[
        str | None, typer.Option("--scene", help="What the stand-ins act on: a scene file or a shipped scene.")
    ] = None,
    control: Annotated[
        int | None, typer.Option("--control", min=0, max=65535, help="Port for injecting faults, 0 for a free one.")
    ] = None,
    port: Annotated[
        list[str] | None,
        typer.Option("--port", metavar="WIRE=PORT", help="Port of a wire, such as rtu=54321; 0 for a free one."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of everything random.")] = 0,
    activated: Annotated[bool, typer.Option("--activated", help="Grippers stand as after their activation.")] = False,
    with_input: Annotated[bool, typer.Option("--with-input", help="End when standard input ends.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Say where the wires are as one line of JSON.")] = False,
) -> None:
    """Stand in for the devices of a cell on this machine, until stopped: they speak the devices' protocols to their real clients."""
    from stretch_bt.hardware.emulators.registry import stand_in_class
    from stretch_bt.hardware.emulators.serve import serving_elsewhere

    classes = {name: stand_in_class(name) for name in devices}
    ports = _ports(port or [], {name: list(cls.PORTS) for name, cls in classes.items()})
    _check_host(host)
    with serving_elsewhere(
        devices, scene=scene, seed=seed, host=host, control=control, ports=ports, activated=activated
    ) as servers:
        served = servers.served
        if json_:
            emit_json(served.to_json(), indent=None, last=False)
        else:
            for name, wires in served.wires.items():
                typer.echo(f"{name}: " + ", ".join(f"{wire} at {place}" for wire, place in wires.items()))
            if served.control is not None:
                typer.echo("control at {}:{}".format(*served.control))
            typer.echo("Ctrl-C ends it.")
        sys.stdout.flush()
        _wait(servers, with_input)


def _check_host(host: str) -> None:
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        raise InvalidInput(f"{host!r} is no address to listen on; write one such as 127.0.0.2") from None
    if not address.is_loopback:
        warn(f"{host} can be reached from other machines, and nothing here asks for a password")


def _ports(texts: list[str], wires: dict[str, list[str]]) -> dict[str, dict[str, int]]:
    """Return the ports by stand-in and wire; raises InvalidInput for a text that is not `wire=port`."""
    ports: dict[str, dict[str, int]] = {}
    for text in texts:
        wire, _, number = text.partition("=")
        owners = [name for name, known in wires.items() if wire in known]
        if not owners or not number.isdecimal() or int(number) > 65535:
            known = [w for one in wires.values() for w in one]
            told = f"--port {text!r} is not a wire and a port; the wires are {', '.join(known)}"
            raise InvalidInput(f"{told}: write {wire if owners else known[0]}=54321")
        ports.setdefault(owners[0], {})[wire] = int(number)
    return ports


def _wait(servers: Servers, with_input: bool) -> None:
    """Return when standard input ends, where that is asked for; else only a signal ends it, or a stand-in that fails."""
    while True:
        servers.check()
        ready = select.select([sys.stdin] if with_input else [], [], [], 1.0)[0]
        if ready and not os.read(sys.stdin.fileno(), 4096):
            return
