"""Where the code of a node, driver or module broke: its last own line, and the whole traceback."""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import FrameSummary

from stretch_bt.errors import InvalidInput, NodeError, StretchError, TreeError, named, writable
from stretch_bt.forked import alone

__all__ = ["Broken", "blame", "own_code", "place_of", "place_of_thread"]

_HERE = Path(__file__).parent
#: code that ticks, imports or checks a node, and is not the node
_AROUND = (
    Path(__file__),
    _HERE / "tree",
    _HERE / "runtime",
    _HERE / "cli",
    _HERE / "behaviors" / "_motion.py",
    _HERE / "hardware" / "device_entries.py",
    _HERE / "hardware" / "implementations.py",
    _HERE / "hardware" / "own_modules.py",
    _HERE / "hardware" / "wire_thread.py",
    _HERE / "hardware" / "monitored",
    Path(threading.__file__),
)
_AROUND_TOO = ("py_trees", "importlib")


class Broken(dict[str, str]):
    """One error of own code as JSON: `at`, file:line of the last own frame, and the `traceback`."""


def blame(error: BaseException) -> Broken | None:
    """Return where an error of own code came up; None where the words of the error say all.

    For a refusal of this package, the words say all but where the user's own code asked for it.
    """
    cause = error
    while isinstance(cause, NodeError | TreeError) and cause.__cause__ is not None:
        cause = cause.__cause__
    told = isinstance(cause, StretchError) and not isinstance(cause, NodeError)
    if told and not (isinstance(cause, InvalidInput) and _is_foreign(cause)):
        return None
    at = place_of(cause)
    text = "".join(map(_shown, traceback.format_exception(cause)))
    return Broken(at=at, traceback=text) if at else None


def _is_foreign(error: BaseException) -> bool:
    """Whether an error came through code that is not of this package."""
    frames = list(_own(traceback.extract_tb(error.__traceback__)))
    return bool(frames) and not Path(frames[0].filename).is_relative_to(_HERE)


def _shown(part: str) -> str:
    """Return a part of a traceback, cut off where an error's text is very long."""
    return writable(part).rstrip("\n") + "\n"


def place_of(error: BaseException) -> str:
    """Return `file:line in function` of the last frame in the folder of the node or module that broke, or nothing."""
    return _last_own(traceback.extract_tb(error.__traceback__))


def place_of_thread(thread: threading.Thread) -> str:
    """Return where a thread is now, `file:line in function` as `place_of` has it, or nothing."""
    frame = sys._current_frames().get(thread.ident or 0)
    return "" if frame is None else _last_own(traceback.extract_stack(frame))


def _last_own(stack: Iterable[FrameSummary]) -> str:
    frames = list(_own(stack))
    if not frames:
        return ""
    home = Path(frames[0].filename).parent
    last = [frame for frame in frames if Path(frame.filename).is_relative_to(home)][-1]
    return f"{_from_here(Path(last.filename))}:{last.lineno} in {last.name}"


@contextmanager
def own_code(path: str, what: str) -> Iterator[None]:
    """Turn an error of own code before the first tick into NodeError, which names the node at `path` and the line."""
    try:
        with alone():
            yield
    except StretchError:
        raise
    except (Exception, SystemExit) as error:
        at = place_of(error)
        reason = f"{what} broke ({named(error)}){at and f' at {at}'}"
        raise NodeError(path, reason) from error


def _own(stack: Iterable[FrameSummary]) -> Iterator[FrameSummary]:
    """Yield the frames from the first that is neither ours around a node nor of the import machinery."""
    inside = False
    for frame in stack:
        path = Path(frame.filename)
        of_others = {path.parent.name, path.parent.parent.name}.intersection(_AROUND_TOO)
        around = any(path.is_relative_to(folder) for folder in _AROUND) or of_others
        inside = inside or not (around or frame.filename.startswith("<"))
        if inside:
            yield frame


def _from_here(path: Path) -> Path:
    try:
        here = Path.cwd()
    except FileNotFoundError:  # somebody removed it: places are shown in full
        return path
    return path.relative_to(here) if path.is_relative_to(here) else path
