"""Every error the package raises on purpose.

::

    StretchError
    ├── FileError                the file is wrong: carries diagnostics with line and column
    │   ├── TreeError
    │   ├── SceneError
    │   ├── CellError
    │   ├── MocksError
    │   ├── SweepError
    │   └── RecordError
    ├── InvalidInput             an argument has the wrong shape, type, unit or range
    ├── NoAnswer                 the numbers carry no answer; `.reason` says why
    │   ├── NoContact
    │   ├── IllConditioned
    │   ├── Absent               a key or a field is read that holds none
    │   ├── Refused              a node or subtree that `do` ticked ended with FAILURE
    │   └── NoEquilibrium
    │       └── Impossible
    ├── DeviceFault              a device says no; it stays until a new run
    │   ├── DeviceLost
    │   ├── StaleReading
    │   ├── LimitExceeded
    │   │   └── BeyondLimits     the plan is wrong, not the device: a NoAnswer too, which a node turns into FAILURE
    │   └── NotReady
    ├── UnsetKey                 a key is read before anything wrote it
    ├── NodeError                the code of a node broke, or broke its contract; names the node's path
    └── MissingExtra             an optional package is needed; says what to install
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

__all__ = [
    "Absent",
    "BeyondLimits",
    "CellError",
    "DeviceFault",
    "DeviceLost",
    "Diagnostic",
    "FileError",
    "IllConditioned",
    "Impossible",
    "InvalidInput",
    "LimitExceeded",
    "MissingExtra",
    "MocksError",
    "NoAnswer",
    "NoContact",
    "NoEquilibrium",
    "NodeError",
    "NotReady",
    "RecordError",
    "Refused",
    "SceneError",
    "StaleReading",
    "StretchError",
    "SweepError",
    "TreeError",
    "UnsetKey",
]


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding about a file; line and column count from 1, `hint` says what to write instead."""

    file: str
    line: int
    column: int
    severity: Literal["error", "warning"]
    code: str
    message: str
    hint: str = ""
    length: int = field(default=1, compare=False)

    def __str__(self) -> str:
        text = f"{self.file}:{self.line}:{self.column} {self.severity}[{self.code}]: {self.message}"
        return f"{text}; {self.hint}" if self.hint else text

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `check --json` prints."""
        fields = asdict(self)
        del fields["length"]
        return fields


#: characters of a reason or of an error's text; more help nobody, and fill terminals and records
LONGEST_TEXT = 4000


def writable(text: object) -> str:
    """Return a text that every file and terminal takes: characters that UTF-8 cannot hold are escaped, the end of a very long one cut off."""
    whole = _made(str, text)
    if len(whole) > LONGEST_TEXT:
        # with room for the paths and names that are put before it, which must not cut off the note
        whole = f"{whole[: LONGEST_TEXT * 3 // 4]}... (cut off; it has {len(whole)} characters)"
    return whole.encode("utf-8", "backslashreplace").decode("utf-8")


def shown(value: object) -> str:
    """Return the repr of any value, also of one whose repr breaks."""
    return _made(repr, value)


def named(error: BaseException) -> str:
    """Return the class of an error and its text, also of one whose text breaks."""
    return f"{type(error).__name__}: {_made(str, error)}"


def _made(write: Callable[[object], str], value: object) -> str:
    try:
        return write(value)
    except Exception as error:  # a broken text must not hide what it was for
        return f"<a {type(value).__name__} whose text cannot be made: {type(error).__name__}>"


def _reason(error: Exception, reason: str) -> str:
    if not isinstance(reason, str):
        raise TypeError(f"{type(error).__name__} takes its reason as text, one sentence, not a {type(reason).__name__}")
    return writable(reason)


class StretchError(Exception):
    """Base of every error raised on purpose."""

    #: folder of the record of a run that it ended before the first tick
    record: str | None = None


class FileError(StretchError):
    """A file is wrong; `.diagnostics` says where and what to write instead."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__("\n".join(str(d) for d in self.diagnostics))


class TreeError(FileError):
    """A tree file, or one that it imports, is wrong."""


class SceneError(FileError):
    """A scene file is wrong."""


class CellError(FileError):
    """A cell file is wrong."""


class MocksError(FileError):
    """A mocks file is wrong, or does not fit its tree."""


class SweepError(FileError):
    """A sweep file is wrong, or does not fit its trees."""


class RecordError(FileError):
    """A record folder is missing, incomplete or damaged."""


class InvalidInput(StretchError, ValueError):
    """An argument has the wrong shape, type, unit or range; the text says what was expected."""

    def __init__(self, *texts: object) -> None:
        super().__init__(*map(writable, texts))


class NoAnswer(StretchError):
    """The numbers carry no answer; `.reason` says why in one sentence."""

    def __init__(self, reason: str) -> None:
        self.reason = _reason(self, reason)
        super().__init__(self.reason)


class Absent(NoAnswer):
    """A key, or a field of a record, holds `none`: its writer had no value for it."""


class Refused(NoAnswer):
    """A node or subtree that was ticked from Python ended with FAILURE; `.path` is the node that gave the reason."""

    def __init__(self, reason: str, path: str = "") -> None:
        super().__init__(reason)
        self.path = path


class NoContact(NoAnswer):
    """Nothing is in contact where a contact is needed."""


class IllConditioned(NoAnswer):
    """The data do not determine the quantity asked for."""


class NoEquilibrium(NoAnswer):
    """The mechanics have no solution, or none was found within the budget."""


class Impossible(NoEquilibrium):
    """The mechanics provably have no solution: no other solver, mesh or budget finds one."""


class DeviceFault(StretchError):
    """A device refuses, fails or is gone; `.device` names it, `.reason` says why."""

    def __init__(self, device: str, reason: str) -> None:
        self.device = device
        self.reason = _reason(self, reason)
        super().__init__(f"{device}: {self.reason}")

    def fields(self) -> dict[str, Any]:
        """Return the fields of the fault as plain values: the arguments of its class by their names."""
        return {"device": self.device, "reason": self.reason}

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(self.fields().values())


class DeviceLost(DeviceFault):
    """The connection to a device broke, or never came up."""


class StaleReading(DeviceFault):
    """A reading is older than its consumer accepts."""


class LimitExceeded(DeviceFault):
    """A device is past a limit of the cell."""


class BeyondLimits(LimitExceeded, NoAnswer):
    """A command asks for more than the cell allows, or the device can reach; nothing moved, and the device is as it was.

    `.concerns` names the limits that a port of the node may have for it, as in `port(limit="depth")`.
    """

    def __init__(self, device: str, reason: str, concerns: Sequence[str] = ()) -> None:
        super().__init__(device, reason)
        self.reason = _reason(self, reason)  # NoAnswer puts the device before it
        self.concerns = tuple(concerns)

    def fields(self) -> dict[str, Any]:
        """Return device, reason and concerns."""
        return {**super().fields(), "concerns": list(self.concerns)}


class NotReady(DeviceFault):
    """A command was given to a device that is closed or in fault."""


class UnsetKey(StretchError):
    """A key is read before anything wrote it."""


class NodeError(StretchError):
    """The code of a node broke, or broke the contract of a node; `.path` names the node."""

    def __init__(self, path: str, reason: str) -> None:
        self.path = path
        self.reason = writable(reason)
        super().__init__(f"{path}: {self.reason}")


class MissingExtra(StretchError, ImportError):
    """An optional package is needed; the text says what to install."""
