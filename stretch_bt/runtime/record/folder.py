"""Where a record lives: the names of its files, and claiming a folder for a new one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import Literal

from stretch_bt.errors import Diagnostic, RecordError, StretchError

__all__ = [
    "EVENTS",
    "FORMAT",
    "KEPT",
    "MCAP",
    "REPORT",
    "RESULT",
    "RUN",
    "Kept",
    "claim",
    "damaged",
    "not_empty",
    "readable",
    "refuse",
]

FORMAT = "stretch-record/1"
#: kept part of a run: everything, the events without the readings of devices, or no record
Kept = Literal["full", "events", "none"]
KEPT: tuple[Kept, ...] = ("full", "events", "none")
RUN, EVENTS, MCAP, RESULT, REPORT = "run.json", "events.jsonl", "record.mcap", "result.json", "report.html"


def refuse(path: Path, code: str, message: str, hint: str = "", line: int = 1) -> RecordError:
    """Return the error that says what is wrong with a record."""
    return RecordError([Diagnostic(str(path), line, 1, "error", code, message, hint)])


def damaged(path: Path, message: str, line: int = 1) -> RecordError:
    """Return the error that says which part of a record is not as it was written."""
    hint = "take the record from where it was made, or record the run again"
    return refuse(path, "record-damaged", message, hint, line)


@contextmanager
def readable(folder: Path) -> Iterator[None]:
    """Turn whatever the content of a record leads its reader into, into a RecordError.

    What a recorder wrote is held against its digests; this is for what somebody else put together.
    """
    try:
        yield
    except (LookupError, TypeError, AttributeError, ValueError, OverflowError, RecursionError) as error:
        if isinstance(error, StretchError):
            raise
        raise damaged(folder, f"it cannot be read: {type(error).__name__}: {error}") from error


def claim(folder: Path | None, what: str = "a record") -> Path:
    """Return the absolute path of an empty folder, made where it is missing; None takes a new one under ./runs.

    `what` goes into it, for messages.

    Raises
    ------
    RecordError
        The folder holds something, is a file, or cannot be made.
    """
    try:
        return _next_free(Path("runs").absolute()) if folder is None else _empty(Path(folder).absolute(), what)
    except OSError as error:
        place = Path(error.filename or folder or "runs")
        if folder is None and error.filename is None:
            message = f"the current folder is gone, and {what} goes into 'runs' in it"
            hint = "go to a folder that is there, or name a folder with --out"
            raise refuse(place, "record-folder", message, hint) from error
        message = f"cannot make {what} here: {error.strerror}"
        raise refuse(place, "record-folder", message, "name another folder with --out") from error


def _empty(folder: Path, what: str) -> Path:
    if folder.exists() and not folder.is_dir():
        raise refuse(folder, "record-folder", f"this is a file; {what} is a folder", "name a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise not_empty(folder)
    return folder


def not_empty(folder: Path) -> RecordError:
    """Return the refusal of a folder that holds something."""
    return refuse(folder, "record-not-empty", "the folder is not empty", "name a new folder, or empty this one")


def _next_free(runs: Path) -> Path:
    runs.mkdir(parents=True, exist_ok=True)
    stamp = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
    for number in count(1):
        folder = runs / f"{stamp}-{number}"
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        return folder
    raise AssertionError("count() does not end")
