"""`stretch-bt report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["command"]


def command(
    record: Annotated[Path, typer.Argument(help="The folder of a record.")],
    out: Annotated[Path | None, typer.Option(help="Write to this file; by default report.html in the record.")] = None,
) -> None:
    """Write the report of a record as one HTML page."""
    from stretch_bt.runtime.report import write_report

    typer.echo(str(write_report(record, out)))
