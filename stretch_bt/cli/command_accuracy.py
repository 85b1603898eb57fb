"""`stretch-bt accuracy`."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterable, Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stretch_bt.cli.output import EXIT_FAILURE, emit_json, in_place
from stretch_bt.errors import InvalidInput

if TYPE_CHECKING:
    from stretch_bt.accuracy import Row
    from stretch_bt.accuracy.compare import Comparison

__all__ = ["command"]


def command(
    names: Annotated[list[str] | None, typer.Argument(help="Domains, such as membrane; all when left out.")] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="What fits into 6 CPU s a domain; the rest is skipped.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="Write the rows and a picture into this new folder.")] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write the page of all pictures into this folder; it keeps domains that it has.")
    ] = None,
    from_: Annotated[
        list[Path] | None,
        typer.Option("--from", help="Take the rows of this file, and measure nothing; may be repeated."),
    ] = None,
    compare: Annotated[
        Path | None, typer.Option(help="Flag what is worse or slower than the rows of this file; exit 1 with any.")
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the rows as JSON.")] = False,
) -> None:
    """Measure error against cost, with the error of the reference stated."""
    from stretch_bt.accuracy import domains
    from stretch_bt.accuracy.compare import Comparison
    from stretch_bt.accuracy.file import merged, read

    files, names = _files(from_ or [], names or [])
    chosen = domains(names)
    if quick and files:
        raise InvalidInput("--quick says what is measured, and --from measures nothing; leave one of them out")
    old = None if compare is None else Comparison(read(compare))
    given = merged(row for path in files for row in read(path) if not names or row.domain in names)
    if files and not given:
        raise InvalidInput(
            f"there is no row of {', '.join(names) or 'any domain'} in these files; name a domain that they hold, or none for all"
        )
    beside = [] if page is None else _beside(page, {row.domain for row in given} if files else chosen)
    rows = _kept(given if files else _measured(names, quick, old), out)
    if page is not None:
        _write_page(page, merged([*beside, *rows]))
    if old is not None and not old.shared(rows):
        raise InvalidInput(
            "none of these rows is among the earlier rows, or each was skipped now or then, so that nothing was compared; "
            "name the same domains and cases, without --quick"
        )
    flags = [] if old is None else [old.flag(row) for row in rows]
    if json_:
        emit_json(_documents(rows, flags), last=not any(flags))
    else:
        _show(rows, old, flags)
    if any(flags):
        raise typer.Exit(EXIT_FAILURE)


def _files(files: list[Path], names: list[str]) -> tuple[list[Path], list[str]]:
    """Return files of rows and names of domains: a shell that fills in `--from *.jsonl` leaves all but the first among the names."""
    more = [Path(name) for name in names if files and name.endswith(".jsonl")]
    return [*files, *more], [name for name in names if Path(name) not in more]


def _kept(found: Iterable[Row], out: Path | None) -> list[Row]:
    """Return the rows, which a new folder keeps where one is named, those before an interrupt too."""
    from stretch_bt.accuracy.folder import write
    from stretch_bt.runtime.record.folder import claim

    folder = None if out is None else claim(out)
    rows: list[Row] = []
    try:
        for row in found:
            rows.append(row)
    except KeyboardInterrupt:
        where = "give --out to keep them" if out is None else f"{out} keeps them"
        typer.echo(f"stopped after {len(rows)} row{'s'[: len(rows) != 1]}; {where}", err=True)
        raise
    finally:
        if folder is not None:
            write(folder, rows)
    return rows


def _measured(names: Iterable[str], quick: bool, old: Comparison | None) -> Iterator[Row]:
    from stretch_bt.accuracy import measure

    with redirect_stdout(sys.stderr):  # what other programs print must not get among the result
        for row in measure(names, quick=quick, doubt=None if old is None else old.slower):
            yield row
            in_place(f"{row.domain}: {row.case}")
    in_place("")


def _beside(folder: Path, fresh: Collection[str]) -> list[Row]:
    """Return the rows of other domains that a page has; a folder that cannot hold it is refused before anything is measured."""
    from stretch_bt.accuracy.page import kept

    folder.mkdir(parents=True, exist_ok=True)
    return kept(folder, fresh)


def _write_page(folder: Path, rows: list[Row]) -> None:
    from stretch_bt.accuracy import page

    page.write(folder, rows)


def _documents(rows: list[Row], flags: list[str | None]) -> list[dict[str, Any]]:
    found = [row.to_json() for row in rows]
    for document, flag in zip(found, flags, strict=False):
        document["worse"] = flag
    return found


def _show(rows: list[Row], old: Comparison | None, flags: list[str | None]) -> None:
    from stretch_bt.accuracy import domains
    from stretch_bt.accuracy.table import table

    for name, domain in domains(row.domain for row in rows).items() if rows else ():
        typer.echo(table(name, domain, [row for row in rows if row.domain == name]))
    if old is None:
        return
    worse = [f"{row.domain}: {row.setting}: {row.case}: {flag}" for row, flag in zip(rows, flags, strict=True) if flag]
    typer.echo("\n".join(["", f"{len(worse)} of {old.shared(rows)} rows that were there before are worse", *worse]))
    if missing := old.missing(rows):
        typer.echo(f"{missing} answers of before were not measured")
