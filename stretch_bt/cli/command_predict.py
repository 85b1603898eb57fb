"""`stretch-bt predict`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stretch_bt.cli.output import EXIT_FAILURE, AsJson, emit_json
from stretch_bt.cli.quantities import quantity_of
from stretch_bt.errors import InvalidInput

__all__ = ["command"]


def command(
    calibration: Annotated[Path, typer.Option(help="A file that `stretch-bt calibrate` wrote.")],
    radius: Annotated[str, typer.Option(help="Radius of the sphere, as in 10mm.")],
    stretch: Annotated[str, typer.Option(help="Stretch past the rest length, as in 30mm.")],
    depth: Annotated[str, typer.Option(help="Depth past first contact, as in 8mm.")],
    json_: AsJson = False,
) -> None:
    """Print the force that a calibrated hand feels from a sphere, with its standard deviation."""
    from stretch_bt.model import ForceModel

    model = ForceModel.load(calibration)
    given = {"--radius": radius, "--stretch": stretch, "--depth": depth}
    place = [quantity_of(option, "Length", text) for option, text in given.items()]
    if place[0] <= 0:
        raise InvalidInput(f"--radius: a sphere has one above 0, not {radius}; write it as in 10mm")
    try:
        force, sd = model.predict(place[0], place[1], place[2])
    except InvalidInput as error:
        if json_:
            emit_json({"force_N": None, "sd_N": None, "in_range": False, "reason": str(error)})
        typer.secho(f"no answer: {error}", fg=typer.colors.RED, err=True)
        raise typer.Exit(EXIT_FAILURE) from None
    measured = model.in_range(place[0], place[1], place[2])
    if json_:
        emit_json({"force_N": force, "sd_N": sd, "in_range": measured})
    else:
        beyond = "" if measured else ", beyond what was measured"
        typer.echo(f"{force:.4g} +- {sd:.2g} N ({model.kind}{beyond})")
