"""Running one item of a sweep: a `Spec` in, its row out, and nothing else of the process changed."""

from __future__ import annotations

import os
import platform
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from stretch_bt.errors import DeviceFault, MissingExtra, NoAnswer, StretchError, named, writable
from stretch_bt.hardware.imported_texts import note_imported
from stretch_bt.quantity_text import format_duration
from stretch_bt.runtime.copies import copies_of
from stretch_bt.runtime.task import RunResult, run
from stretch_bt.sweep.job import Ran
from stretch_bt.sweep.laid_out import fresh_folder, laid_out
from stretch_bt.sweep.memory import give_back
from stretch_bt.sweep.own_copies import copies_alone
from stretch_bt.sweep.package_digest import another_package, package_digest
from stretch_bt.sweep.spec import TIMED_OUT, Spec
from stretch_bt.sweep.wall_limit import WallLimit

__all__ = ["run_item"]


def run_item(spec: Spec) -> Ran:
    """Run an item, and return its row, whatever it came to, errors and faults included.

    Raises
    ------
    InvalidInput
        This process has another `stretch_bt` than the one that the key was made with, or imported another module of
        the same name.
    MissingExtra
        This machine lacks a package that the item needs.
    KeyboardInterrupt
        A signal came while the run was prepared.
    """
    if spec.source != package_digest():
        raise another_package(_worker())
    try:
        return _ran(spec)
    finally:
        give_back()


def _ran(spec: Spec) -> Ran:
    base = laid_out(spec.files)
    home = base / spec.home
    limit = WallLimit(spec.limit)
    worker = _worker()
    homes = [os.path.normpath(Path(spec.home, name)) for name in (spec.tree, spec.cell) if name is not None]
    with (
        copies_alone(base, spec.files, spec.origin, [name for name in homes if name in spec.files]),
        fresh_folder(spec.files, spec.home) as folder,
        redirect_stdout(sys.stderr),
        copies_of(spec.origin, base),  # the folder of a worker goes with it
    ):
        try:
            result = run(
                _at(spec.tree, home),
                scene=_at(spec.scene, home),
                cell=_at(spec.cell, home),
                params=spec.params,
                seed=spec.seed,
                tolerance=spec.tolerance,
                record=spec.record,
                out=None if spec.record == "none" else folder / "record",
                watch=limit.watch,
            )
        except MissingExtra as error:  # of this machine, not of the item
            what = f"{worker} lacks a package that the item needs: {writable(error)}"
            raise MissingExtra(f"{what}, on each machine with workers, and go on with --resume") from None
        except Exception as error:  # one item that breaks must not end a sweep
            status, reason = _refused(error)
            return Ran(spec.row(status, _without(base, home, reason), worker=worker))
        finally:  # nodes may import more as they tick
            note_imported([str((home / spec.tree).parent.resolve())])
        row = _row(spec, result, limit)
        row |= {"reason": _without(base, home, row["reason"]), "worker": worker}
        stopped = result.status == "INTERRUPTED" and limit.signalled
        return Ran(row, None if result.record is None else _files(Path(result.record)), stopped)


def _worker() -> str:
    """Return host and process."""
    return f"{platform.node()}:{os.getpid()}"


def _at(name: str | None, home: Path) -> Any:
    """Return the file of a name where it is one of the item's, else the name of a shipped one."""
    return name if name is None or not (home / name).is_file() else home / name


def _row(spec: Spec, result: RunResult, limit: WallLimit) -> dict[str, Any]:
    if spec.limit is not None and limit.passed:
        return spec.row(TIMED_OUT, f"no end within {format_duration(spec.limit)} of wall time", result)
    return spec.row(result.status, result.reason, result)


def _refused(error: Exception) -> tuple[str, str]:
    """Return the status and the reason of a run that did not begin, as `run` would print them, for a sweep file."""
    if not isinstance(error, StretchError):
        return "ERROR", writable(named(error))
    fault = isinstance(error, DeviceFault) and not isinstance(error, NoAnswer)
    return "FAULT" if fault else "ERROR", writable(error).replace("--tolerance", "tolerance")


def _without(base: Path, home: Path, text: str) -> str:
    """Return a text without the folders of this worker, which differ from one to the next."""
    return text.replace(f"{home}{os.sep}", "").replace(f"{base}{os.sep}", "")


def _files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
