"""Carrying out a sweep: its items through an engine, each row to the disk as it comes, and what came of all of them."""

from __future__ import annotations

import multiprocessing
import shutil
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path
from typing import Any

from stretch_bt.errors import InvalidInput, RecordError
from stretch_bt.runtime.record.folder import EVENTS, MCAP, Kept, claim
from stretch_bt.runtime.sweep_check import check_sweep
from stretch_bt.sweep.engines import Engine
from stretch_bt.sweep.items import items_of
from stretch_bt.sweep.job import Ran
from stretch_bt.sweep.picture import write_pictures
from stretch_bt.sweep.rows import ROWS, RowFile
from stretch_bt.sweep.serial import serial
from stretch_bt.sweep.spec import AGAIN
from stretch_bt.sweep.summary import Summary, can_be_summed_up, write_summary

__all__ = ["Progress", "Swept", "sweep"]

#: copy of the sweep file in its folder, and where records of its items are
SWEEP, RECORDS = "sweep.yaml", "records"

#: called with each row, the number of items that were run, and the number of items to run
Progress = Callable[[dict[str, Any], int, int], None]


@dataclass(frozen=True, slots=True)
class Swept:
    """What came of a sweep: its folder, how many items had their row before, and of how many items a signal ended the process."""

    folder: Path
    before: int
    stopped: int
    wall_seconds: float
    summary: Summary
    pictures: list[str] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """Return what `sweep --json` prints."""
        return {
            "folder": str(self.folder),
            "before": self.before,
            "stopped": self.stopped,
            "wall_seconds": self.wall_seconds,
            **self.summary.to_json(),
            "pictures": self.pictures,
        }

    @property
    def whole(self) -> bool:
        """Whether each item has a row of its own end."""
        left = self.summary.items - sum(self.summary.statuses.values())
        return not left and not any(self.summary.statuses.get(status) for status in AGAIN)


def sweep(
    file: str | Path,
    engine: Engine = serial,
    *,
    out: str | Path | None = None,
    resume: bool = False,
    progress: Progress = lambda row, done, of: None,
) -> Swept:
    """Run the items of a sweep file, and write rows, summary and pictures into a folder.

    Parameters
    ----------
    file
        A sweep file.
    engine
        Where the items are run; by default one after the other in this process.
    out
        The folder, empty or absent; by default a new one under ./runs.
    resume
        Go on in the folder `out`: items that have a row there are not run again, unless it is `killed` or `timed_out`.
    progress
        Told of each row.

    Raises
    ------
    SweepError
        The file is wrong, or what it names; nothing was run.
    InvalidInput
        The folder cannot be used, or a Python module was changed after this process imported it.
    """
    _end_reader()
    began = time.perf_counter()
    checked = check_sweep(file).require()
    items = items_of(checked)
    folder = _folder(out, resume)
    with closing(RowFile(folder / ROWS, can_be_summed_up)) as rows:
        done = _done(rows, folder / RECORDS, checked.file.record)
        left = sum(spec.key not in done for spec in items)
        try:
            ahead = (spec for spec in items if spec.key not in done)
            with _begun(engine(ahead), rows, checked.file.path) as rans:
                stopped = _written(rans, rows, left, progress)
        except KeyboardInterrupt as error:
            there = sum(spec.key in rows.statuses for spec in items)
            error.add_note(f"{there} of {len(items)} items have a row; go on with --resume --out {folder}")
            raise
        with _on_disk("the summary", folder):
            summary = write_summary(folder, len(items), rows.rows(spec.key for spec in items))
    with _on_disk("the pictures", folder):
        pictures = write_pictures(folder, summary)
    return Swept(folder, len(items) - left, stopped, time.perf_counter() - began, summary, pictures)


def _end_reader() -> None:
    """End a worker of Dask that reads the script which begins this sweep, before it sweeps too; `cluster` says why none begins."""
    process = multiprocessing.current_process()
    if getattr(process, "_inheriting", False) and process.name.startswith("Dask Worker"):
        raise SystemExit(1)


def _same(one: Path, other: Path) -> bool:
    return one.exists() and other.exists() and one.samefile(other)


def _done(rows: RowFile, records: Path, kept: Kept) -> set[str]:
    """Return the keys of the items that are not run again: those that have their row, and all that is kept of a run."""
    done = {key for key, status in rows.statuses.items() if status not in AGAIN}
    if kept == "none":
        return done
    least = MCAP if kept == "full" else EVENTS
    return {key for key in done if rows.statuses[key] in ("ERROR", "FAULT") or (records / key / least).is_file()}


@contextmanager
def _begun(rans: Generator[Ran, None, None], rows: RowFile, file: Path) -> Iterator[Iterator[Ran]]:
    """Hand out what an engine yields once it has begun.

    Where it breaks before that, no folder without a row is left behind: the next try would find it in use.
    """
    with closing(rans):
        try:
            _copy(file, rows.path.parent / SWEEP)
            first = list(islice(rans, 1))
        except Exception:
            if not rows.statuses:
                _clear(rows.path.parent, file)
            raise
        yield chain(first, rans)


def _copy(file: Path, copy: Path) -> None:
    content = file.read_bytes()
    if not _same(file, copy):
        with _on_disk("the copy of the sweep file", copy):
            copy.write_bytes(content)


@contextmanager
def _on_disk(what: str, path: Path) -> Iterator[None]:
    """Say what could not be written where the disk takes no more."""
    try:
        yield
    except OSError as error:
        message = f"{error.filename or path}: cannot write {what}: {error.strerror}"
        raise InvalidInput(f"{message}; make room and go on with --resume") from None


def _clear(folder: Path, file: Path) -> None:
    """Remove a folder in which no item has run, but for the files of others."""
    if not _same(file, folder / SWEEP):  # which may be all that there is of the file
        for name in (ROWS, SWEEP):
            (folder / name).unlink(missing_ok=True)
        with suppress(OSError):  # somebody else's file is in it
            folder.rmdir()


def _written(rans: Iterator[Ran], rows: RowFile, left: int, progress: Progress) -> int:
    """Write the rows of items that were run; return of how many a signal ended the process, which have none."""
    stopped = 0
    for done, ran in enumerate(rans, 1):
        if ran.stopped:
            stopped += 1
        else:
            _keep(rows, ran)
        progress(ran.row, done, left)
    return stopped


def _keep(rows: RowFile, ran: Ran) -> None:
    """Write the record of an item and then its row, so that no row is without its record."""
    if ran.record is not None:
        record = rows.path.parent / RECORDS / ran.row["key"]
        with _on_disk("the record of an item", record):
            _put(ran.record, record)
    rows.write(ran.row)


def _put(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder of their own, in the place of another; it is there whole or not at all, whatever ends this process."""
    new, old = (folder.with_name(f".{folder.name}.{what}") for what in ("new", "old"))
    for left in (new, old):  # of a sweep that was killed here
        shutil.rmtree(left, ignore_errors=True)
    try:
        new.mkdir(parents=True)
        for name, content in files.items():
            path = new / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    except OSError:
        shutil.rmtree(new, ignore_errors=True)
        raise
    if folder.exists():
        folder.rename(old)
    new.rename(folder)
    shutil.rmtree(old, ignore_errors=True)


def _folder(out: str | Path | None, resume: bool) -> Path:
    if not resume:
        if out is not None and (Path(out) / ROWS).is_file():
            raise InvalidInput(f"{out} holds the rows of a sweep; go on with --resume, or name a new folder")
        return _claimed(out)
    if out is None:
        raise InvalidInput("--resume goes on in a folder; name it with --out")
    folder = Path(out).absolute()
    if folder.is_dir() and any(folder.iterdir()) and not (folder / ROWS).is_file():
        raise InvalidInput(f"{folder}: it holds no {ROWS} of a sweep; name the folder of one, or a new folder")
    if folder.is_dir():
        return folder
    return _claimed(folder)


def _claimed(out: str | Path | None) -> Path:
    try:
        return claim(None if out is None else Path(out), "the output of a sweep")
    except RecordError as error:
        found = error.diagnostics[0]
        raise InvalidInput(f"{found.file}: {found.message}; {found.hint}") from None
