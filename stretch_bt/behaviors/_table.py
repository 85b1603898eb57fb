"""The table that a characterisation or a sensitivity map writes: one a run, in the record and in the file that was named."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model.calibration import characterization, sensitivity
from stretch_bt.model.calibration.conditioning import CONDITIONED, Conditioning
from stretch_bt.model.calibration.form import decoded, text_of
from stretch_bt.model.calibration.protocol import State
from stretch_bt.source.bounds import read_bytes
from stretch_bt.tree.context import Context

__all__ = ["TableFile", "check_table", "open_table"]

#: entries that must be equal for rows to belong to one table
_ALIKE = ("hand", "scene", "cell", "protocol")
P = TypeVar("P", bound=State)


class _Parsed(Protocol):
    """A table as it is read."""

    @property
    def provenance(self) -> Mapping[str, Any]: ...

    def presses(self) -> Iterable[State]: ...


@dataclass(frozen=True, slots=True)
class _Kind:
    """A kind of table: its name in a record, its format, its presses and how many lines each has, and how it is written and read."""

    name: str
    format: str
    press: type[State]
    lines: int
    first_lines: Callable[[Mapping[str, Any]], str]
    line: Callable[[Any], str]
    parse: Callable[[str, str], _Parsed]

    @property
    def before(self) -> str:
        """Name of the copy of a continued table as it was at first, in the run's record."""
        return f"{Path(self.name).stem}_before.csv"

    def read(self, path: Path) -> _Parsed:
        """Return the table in a file; raises InvalidInput where the file is no table."""
        return self.parse(text_of(path), str(path))


_FORCES = _Kind(
    characterization.NAME,
    characterization.FORMAT,
    characterization.PressRow,
    1,
    characterization.first_lines,
    characterization.table_line,
    characterization.parse_table,
)
_SIZES = _Kind(
    sensitivity.NAME,
    sensitivity.FORMAT,
    sensitivity.Sensed,
    len(sensitivity.METHODS),
    sensitivity.first_lines,
    sensitivity.sensed_lines,
    sensitivity.parse_sensitivity,
)


def _kind_of(protocol: str) -> _Kind:
    return _SIZES if protocol == "sensitivity" else _FORCES


class TableFile:
    """A table that grows by a press at a time, each on the disk before the next one; `presses` are the presses in it.

    Growing makes a new table; no record prints it.
    """

    __slots__ = ("files", "kind", "presses", "provenance")

    def __init__(
        self, kind: _Kind, files: Sequence[Path], provenance: Mapping[str, Any], presses: tuple[Any, ...]
    ) -> None:
        self.kind, self.files, self.provenance, self.presses = kind, files, provenance, presses

    def grown(self, press: State) -> TableFile:
        """Return the table with one more press, which every file of it then holds."""
        line = self.kind.line(press)
        for file in self.files:
            _write(file, line, "a")
        return TableFile(self.kind, self.files, self.provenance, (*self.presses, press))

    def of(self, press: type[P]) -> tuple[P, ...]:
        """Return its presses; raises IllConditioned where they are of another kind."""
        if self.kind.press is not press:
            raise IllConditioned(f"the open table is a {self.kind.name}; run 'plan_protocol' with another 'protocol'")
        return self.presses


def open_table(context: Context, name: str, protocol: str, conditioned: Conditioning) -> TableFile:
    """Return the table of a run: the one that is named, or a new one in the record.

    A named table keeps its rows, and the record gets a copy of it, so that the record alone shows all of them. A last line
    that was cut short is removed first. A replay begins with the table that its record began with, and writes to no other place.

    Raises
    ------
    IllConditioned
        The table is of another hand, scene, cell or protocol, or of a membrane that was conditioned otherwise.
    InvalidInput
        It is no table, or cannot be written.
    """
    return _open(context, name, _kind_of(protocol), _provenance(context, protocol, conditioned))


def check_table(context: Context, name: str, protocol: str, conditioned: Conditioning) -> None:
    """Refuse, before a run, a table that cannot be continued or begun; changes no file.

    Raises
    ------
    InvalidInput
        `open_table` would refuse the table, or its file cannot be written.
    """
    path, kind = Path(name), _kind_of(protocol)
    if path.is_dir() or not path.parent.is_dir():
        what = "it is a folder" if path.is_dir() else f"there is no folder {path.parent}"
        raise InvalidInput(f"{path}: the table cannot be written ({what}); name a file in a folder that exists")
    place, needed = (path, os.R_OK | os.W_OK) if path.exists() else (path.parent, os.W_OK | os.X_OK)
    if not os.access(place, needed):
        raise InvalidInput(f"{path}: the table cannot be read and written (no permission); name another file")
    content = _whole(kind, read_bytes(path)) if path.exists() else b""
    if content:
        try:
            table = kind.parse(decoded(content, path), name)
            _check_alike(path, table.provenance, _provenance(context, protocol, conditioned))
        except IllConditioned as refusal:
            raise InvalidInput(str(refusal)) from None


def _open(context: Context, name: str, kind: _Kind, provenance: Mapping[str, Any]) -> TableFile:
    folder = context.folder
    if folder is None:
        return _without_record(kind, name, provenance)
    own = folder / kind.name
    files = [own] if context.repeated is not None or not name else [Path(name), own]
    source = files[0]
    if context.repeated is not None:
        before = context.repeated / kind.before
        if before.exists():
            shutil.copyfile(before, own)
    if not _begun(kind, source, provenance) and context.repeated is None and source != own:
        shutil.copyfile(source, folder / kind.before)
    if source != own:
        shutil.copyfile(source, own)
    return _read(kind, files, provenance)


def _without_record(kind: _Kind, name: str, provenance: Mapping[str, Any]) -> TableFile:
    """Return the table of a run that keeps no record: the file that is named, or rows in no file."""
    if not name:
        return TableFile(kind, [], kind.parse(kind.first_lines(provenance), kind.name).provenance, ())
    _begun(kind, Path(name), provenance)
    return _read(kind, [Path(name)], provenance)


def _begun(kind: _Kind, path: Path, provenance: Mapping[str, Any]) -> bool:
    """Mend the file of a table, or begin it where there are no rows yet; return whether it was begun."""
    _mend(kind, path)
    if path.exists() and path.stat().st_size > 0:
        return False
    _write(path, kind.first_lines(provenance), "w")
    return True


def _read(kind: _Kind, files: Sequence[Path], provenance: Mapping[str, Any]) -> TableFile:
    """Return the table that the first of some files holds, if it is of this run's hand, scene, cell and protocol."""
    table = kind.read(files[0])
    _check_alike(files[0], table.provenance, provenance)
    return TableFile(kind, files, table.provenance, tuple(table.presses()))


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
            f"{path}: the membrane of the table is {before or 'held to be conditioned, which the table does not say'}, the membrane "
            f"of this run {now}; name another table, or measure as it was with 'condition', 'stretches' and 'depths'"
        )


def _mend(kind: _Kind, path: Path) -> None:
    """Remove from the end of a table a press that was cut short; all of it when its head is not whole."""
    if not path.exists():
        return
    try:
        with path.open("r+b") as file:
            file.truncate(len(_whole(kind, file.read())))
    except OSError as error:
        raise _unwritten(path, error) from None


def _whole(kind: _Kind, content: bytes) -> bytes:
    """Return a table without a last press that was cut short; content that is no table stays as it is."""
    if not f"# {kind.format}".encode().startswith(content[: len(kind.format) + 2]):
        return content
    lines = content[: content.rfind(b"\n") + 1].splitlines(keepends=True)
    whole = len(lines) - (len(lines) - 2) % kind.lines
    return b"".join(lines[:whole]) if len(lines) >= 2 else b""


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
