"""`stretch-bt press`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from stretch_bt.cli.output import EXIT_FAILURE, AsJson, emit_json, warn
from stretch_bt.cli.quantities import quantity_of
from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.units import KINDS

__all__ = ["command"]


def command(
    indenter: Annotated[
        str, typer.Option(help="sphere:20mm, cylinder:20mm[:rim], cone:45deg[:tip], cube:20mm or height:FILE.npy:1mm")
    ],
    stretch: Annotated[
        str, typer.Option(help="How far the clamps move apart past the gauge and its mount, as in 30mm.")
    ],
    depth: Annotated[str, typer.Option(help="Depth from the flat stretched plane, as in 10mm.")],
    solver: Annotated[str, typer.Option(help="hertz, axisymmetric or sheet")] = "sheet",
    mesh: Annotated[str | None, typer.Option(help="Length of the smallest elements.")] = None,
    shear_modulus: Annotated[str, typer.Option(help="Shear modulus of the membrane.")] = "47.4kPa",
    mount_prestretch: Annotated[
        str, typer.Option(help="How far its mount stretches the membrane past the gauge at stretch 0.")
    ] = "0mm",
    gauge: Annotated[
        str,
        typer.Option(help="Unstretched length of the membrane between the clamps; --mount-prestretch comes on top."),
    ] = "100mm",
    at: Annotated[str, typer.Option(help="Place of the indenter, as in 5mm,0mm.")] = "0mm,0mm",
    tilt: Annotated[str, typer.Option(help="Turns of the indenter about x and y, as in 5deg,0deg.")] = "0deg,0deg",
    effects: Annotated[str, typer.Option(help="Names of effects with commas, as in wrinkling,sag.")] = "",
    plot: Annotated[Path | None, typer.Option(help="Draw the pressed sheet as this picture, as in press.png.")] = None,
    json_: AsJson = False,
) -> None:
    """Press an indenter into the membrane, and print the force and what it touches."""
    from stretch_bt.simulation import press

    _check_plot(plot, solver)  # before minutes of solving
    try:
        result = press(
            indenter,
            quantity_of("--stretch", "Length", stretch),
            quantity_of("--depth", "Length", depth),
            solver=solver,
            mesh=quantity_of("--mesh", "Length", mesh) if mesh else None,
            shear_modulus=quantity_of("--shear-modulus", "Pressure", shear_modulus),
            mount_prestretch=quantity_of("--mount-prestretch", "Length", mount_prestretch),
            gauge=quantity_of("--gauge", "Length", gauge),
            at=_pair("--at", at, "Length"),
            tilt=_pair("--tilt", tilt, "Angle"),
            effects=[name.strip() for name in effects.split(",") if name.strip()],
        )
    except NoEquilibrium as error:
        _tell_refusal(error, as_json=json_)
        raise typer.Exit(EXIT_FAILURE) from None
    _tell(result, plot, as_json=json_)


def _check_plot(path: Path | None, solver: str) -> None:
    """Raise InvalidInput where a picture that is wanted cannot be written, or the solver has nothing to draw."""
    if path is None:
        return
    from stretch_bt.simulation.membrane.picture import check_picture

    check_picture(path)
    if solver in ("hertz", "axisymmetric"):
        raise InvalidInput("only the sheet solver has a surface to draw; leave out --solver, or --plot")


def _tell_refusal(error: NoEquilibrium, *, as_json: bool) -> None:
    if as_json:
        emit_json({"error": NoEquilibrium.__name__, "reason": error.reason})
    typer.secho(f"no equilibrium: {error.reason}", fg=typer.colors.RED, err=True)


def _tell(result: Any, plot: Path | None, *, as_json: bool) -> None:
    for warning in result.warnings:
        warn(warning)
    if plot is not None:
        _draw(result, plot)
    if as_json:
        emit_json(result.to_json())
    else:
        _show(result)


def _pair(option: str, text: str, kind: str) -> tuple[float, float]:
    parts = text.split(",")
    if len(parts) != 2:
        raise InvalidInput(
            f"{option}: {text!r} is not a pair; write two quantities with a comma, as in '5 {KINDS[kind].unit},0 {KINDS[kind].unit}'"
        )
    return quantity_of(option, kind, parts[0]), quantity_of(option, kind, parts[1])


def _draw(result: Any, path: Path) -> None:
    from stretch_bt.simulation.membrane.picture import save_press

    save_press(result.detail, path)


def _show(result: Any) -> None:
    fields = result.to_json()
    contact = fields["contact"]
    error = fields["force_error_N"]
    within = "its error is not known" if error is None else f"standard deviation {error:.2g} N"
    typer.echo(f"force    {fields['force_N']:.4g} N, {within}")
    radius = "" if contact["radius_mm"] is None else f", as large as a disc of radius {contact['radius_mm']:.3g} mm"
    typer.echo(f"contact  {contact['area_mm2']:.4g} mm^2{radius}")
    typer.echo(
        f"balance  {fields['balance']:.1e} of the load, {fields['iterations']} iterations, {1e3 * fields['seconds']:.1f} ms of CPU"
    )
