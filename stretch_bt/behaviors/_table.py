"""The table that a characterisation writes: one a run, in the record and where it was asked for."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model.characterization import FORMAT, NAME, Press, first_lines, parse_table, read_table, table_line
from stretch_bt.model.conditioning import CONDITIONED, Conditioning
from stretch_bt.tree.context import Context

__all__ = ["TableFile", "check_table", "opened", "table_of"]

#: in the record of a run that goes on with a table: how that was at first
_BEFORE = "characterization_before.csv"
#: what must be alike for rows to belong to one table
_ALIKE = ("hand", "scene", "cell", "protocol")


class TableFile:
    """A table that grows by a row at a time, each on the disk before the next press; `presses` are its rows."""

    def __init__(self, files: list[Path], provenance: Mapping[str, Any], presses: list[Press]) -> None:
        self.files = files
        self.provenance = provenance
        self.presses = presses

    def append(self, press: Press) -> None:
        """Write a row to every copy."""
        line = table_line(press)
        for file in self.files:
            _write(file, line, "a")
        self.presses.append(press)


def table_of(context: Context, name: str) -> TableFile:
    """Return the table that this run works on; raises IllConditioned before `next_state` has looked at it."""
    found = context.memory.get((TableFile, name))
    if not isinstance(found, TableFile):
        raise IllConditioned("no table is open; run 'next_state' with the same 'table' first")
    return found


def opened(context: Context, name: str, protocol: str, conditioned: Conditioning) -> TableFile:
    """Return the table of this run, opened once: the one that is named, or a new one in the record.

    A named table keeps its rows, and the record gets a copy of it, so that the record alone tells what was known. A last line
    that was cut short is removed first. A replay begins with the table that its record began with, and writes to no other place.

    Raises
    ------
    IllConditioned
        The table is of another hand, scene, cell or protocol, or of a membrane that was conditioned otherwise.
    InvalidInput
        It is no table, or cannot be written.
    """
    key = (TableFile, name)
    if key not in context.memory:
        context.memory[key] = _open(context, name, _provenance(context, protocol, conditioned))
    found: TableFile = context.memory[key]
    return found


def check_table(context: Context, name: str, protocol: str, conditioned: Conditioning) -> None:
    """Refuse, before a run, a table that cannot be gone on with or begun; changes nothing.

    Raises
    ------
    InvalidInput
        What `opened` would refuse, or a place where nothing can be written.
    """
    path = Path(name)
    if path.is_dir() or not path.parent.is_dir():
        what = "it is a folder" if path.is_dir() else f"there is no folder {path.parent}"
        raise InvalidInput(f"{path}: the table cannot be written ({what}); name a file in a folder that exists")
    place, needed = (path, os.R_OK | os.W_OK) if path.exists() else (path.parent, os.W_OK | os.X_OK)
    if not os.access(place, needed):
        raise InvalidInput(f"{path}: the table cannot be read and written (no permission); name another file")
    content = _whole(path.read_bytes()) if path.exists() else b""
    if content:
        try:
            table = parse_table(content.decode(), name)
            _check_alike(path, table.provenance, _provenance(context, protocol, conditioned))
        except UnicodeDecodeError:
            raise InvalidInput(f"{path}: the table is no text; name the file of a table") from None
        except IllConditioned as refusal:
            raise InvalidInput(str(refusal)) from None


def _open(context: Context, name: str, provenance: Mapping[str, Any]) -> TableFile:
    folder = context.folder or Path()
    own = folder / NAME
    files = [own] if context.repeated is not None or not name else [Path(name), own]
    source = files[0]
    if context.repeated is not None:
        before = context.repeated / _BEFORE
        if before.exists():
            shutil.copyfile(before, own)
    _mend(source)
    if not source.exists() or source.stat().st_size == 0:
        _write(source, first_lines(provenance), "w")
    elif context.repeated is None and source != own and context.folder is not None:
        shutil.copyfile(source, folder / _BEFORE)
    if source != own:
        shutil.copyfile(source, own)
    table = read_table(source)
    _check_alike(source, table.provenance, provenance)
    return TableFile(files, table.provenance, list(table.presses()))


def _provenance(context: Context, protocol: str, conditioned: Conditioning) -> dict[str, Any]:
    about = context.about
    return {
        "hand": asdict(context.hand.geometry),
        "tree": about.get("tree"),
        "scene": about.get("scene"),
        "cell": about.get("cell") or "simulated",
        "seed": about.get("seed"),
        "versions": about.get("versions", {}),
        "protocol": protocol,
        CONDITIONED: conditioned.to_json(),
    }


def _check_alike(path: Path, found: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    for name in _ALIKE:
        if found.get(name) != wanted[name]:
            raise IllConditioned(
                f"{path}: the table is of {name} {found.get(name)!r}, this run is of {wanted[name]!r}; name another table"
            )
    before, now = Conditioning.of(found), Conditioning.of(wanted)
    if before is None and now is not None and now.softens:  # a table that does not say so is held to be conditioned
        return
    if before != now:
        raise IllConditioned(
            f"{path}: the membrane of the table is {before or 'held to be conditioned, which the table does not say'}, that of this "
            f"run {now}; name another table, or measure as it was with 'condition', 'stretches' and 'depths'"
        )


def _mend(path: Path) -> None:
    """Remove what follows the last line end of a table, a row that was cut short; all of it when its head is not whole."""
    if not path.exists():
        return
    try:
        with path.open("r+b") as file:
            file.truncate(len(_whole(file.read())))
    except OSError as error:
        raise _unwritten(path, error) from None


def _whole(content: bytes) -> bytes:
    """Return a table without a last row that was cut short; what is no table stays as it is."""
    kept = content[: content.rfind(b"\n") + 1]
    if not f"# {FORMAT}".encode().startswith(content[: len(FORMAT) + 2]):
        return content
    return kept if kept.count(b"\n") >= 2 else b""


def _write(path: Path, text: str, mode: str) -> None:
    """Write text, and return once the disk has it."""
    try:
        with path.open(mode, encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise _unwritten(path, error) from None


def _unwritten(path: Path, error: OSError) -> InvalidInput:
    return InvalidInput(f"{path}: the table cannot be written ({error.strerror}); name a file in a folder that exists")
