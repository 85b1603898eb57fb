"""`stretch-bt calibrate`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stretch_bt.cli.output import AsJson, emit_json, warn
from stretch_bt.errors import InvalidInput

if TYPE_CHECKING:
    from stretch_bt.model.calibration.calibrate import Calibration

__all__ = ["command"]

_PICTURES = (".png", ".svg", ".pdf")


def command(
    record: Annotated[Path, typer.Argument(help="The record of a run of `characterize`, or its table.")],
    out: Annotated[Path, typer.Option(help="Write the calibration into this file.")],
    model: Annotated[str, typer.Option(help="membrane, paper or sheet")] = "membrane",
    plot: Annotated[
        Path | None, typer.Option(help="Draw forces, moduli and residuals into this file: .png, .svg or .pdf.")
    ] = None,
    json_: AsJson = False,
) -> None:
    """Fit a force model to measured forces; the file serves as the `model` of nodes and of `predict`."""
    from stretch_bt.model import calibrate
    from stretch_bt.model.calibration.characterization import NAME, read_table
    from stretch_bt.model.calibration.measurements import Measurements

    if plot is not None and plot.suffix.lower() not in _PICTURES:
        raise InvalidInput(f"{plot}: a picture is one of {', '.join(_PICTURES)}; name it so")
    for path in filter(None, (out, plot)):
        if not path.parent.is_dir():
            raise InvalidInput(f"{path}: there is no folder {path.parent}; make it first")
    table = read_table(record / NAME if record.is_dir() else record)
    given = Measurements.of(table)
    found = calibrate(given, model, {"characterization": dict(table.provenance), "presses": len(given)})
    found.model.save(out)
    for text in found.warnings:
        warn(text)
    if plot is not None:
        _draw(found, plot)
    emit_json(found.to_json()) if json_ else _show(found, out)


_KPA, _MM = (", kPa", 1e-3), (", mm", 1e3)
#: parameters that have a unit, and how they are shown in it
_SHOWN = {
    "shear_modulus": _KPA,
    "thickness": _MM,
    "mount_prestretch": _MM,
    "floor": _KPA,
    "amplitude": _KPA,
    "decay": _MM,
}


def _show(found: Calibration, out: Path) -> None:
    from stretch_bt.model.calibration.calibrate_membrane import at_an_end
    from stretch_bt.model.calibration.conditioning import Conditioning
    from stretch_bt.model.force.membrane_hand import BOUNDS

    conditioned = Conditioning.of(found.model.provenance)
    for name, value, sd in _parameters(found.to_json()):
        end = " (at its bound)" if name in BOUNDS and at_an_end(name, value) else ""
        if name == "softening" and conditioned is not None and not conditioned.softens:
            end = " (held: the membrane was not conditioned)"
        unit, factor = _SHOWN.get(name.partition(" at ")[0], ("", 1.0))
        typer.echo(f"{name + unit:40} {factor * value:.5g}{end} +- {factor * sd:.2g}")
    if found.zero.common_sd:
        typer.echo(
            f"{'depth offset of all presses, mm':40} {_signed(found.zero.common)} +- {1e3 * found.zero.common_sd:.2g}"
        )
    for diameter, offset in found.zero.indenters:
        typer.echo(f"{f'and of the {1e3 * diameter:.0f} mm indenter, mm':40} {_signed(offset)}")
    typer.echo(f"left of the forces: {100 * found.model.relative_sd:.1f} %")
    for row in found.left_out:
        beyond = ", beyond the others" if row.extrapolated else ""
        said = row.reason if row.mean_absolute is None else f"mean absolute error {row.mean_absolute:.4f} N"
        if row.rms_relative is not None:
            said += f", {100 * row.rms_relative:.1f} % rms from 5 mm of depth and 10 mm of stretch on"
        typer.echo(f"without {1e3 * row.diameter:.0f} mm{beyond}: {said}")
    typer.echo(f"{found.model.kind}: {out}")


def _signed(length: float) -> str:
    return f"{1e3 * length:+.3f}"


def _parameters(fields: dict[str, Any]) -> list[tuple[str, float, float]]:
    """Return name, value and standard deviation of what was fitted, SI."""
    if "hand" in fields:
        return [(name, value, fields["sd"][name]) for name, value in fields["hand"].items()]
    names = ("floor", "amplitude", "decay")
    states = fields["states"]
    return [(f"{n} at {1e3 * s['stretch']:.4g} mm", s[n], s[f"{n}_sd"]) for s in states for n in names]


def _draw(found: Calibration, path: Path) -> None:
    from stretch_bt.model.calibration.picture import save_calibration

    save_calibration(found.model, found.used, path)
