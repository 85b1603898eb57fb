"""The claim to a device at its place: one program has it at a time, because two that command one device undo each other's work.

A claim is a lock of the kernel on a file named after the place, in a folder that only its user can enter. The kernel frees it when
the process ends, however that ends. It holds between the programs of one user on one machine: against others an arm
is kept by its controller, a gripper by nobody. A force sensor has one too, though it is only read: its stream goes to who asked last.
"""

from __future__ import annotations

import fcntl
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self
from urllib.parse import quote

from stretch_bt.errors import NotReady

__all__ = ["Claim", "claims_folder"]

_NAME = "stretch-bt"
_LONGEST_PID = 20
_NOT_OTHERS = 0o077


def claims_folder() -> Path:
    """Return the folder of the files of claims: in the system's folder for the user's running programs, else in the one for temporary files."""
    runtime = os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}"
    if Path(runtime).is_dir() and os.access(runtime, os.W_OK | os.X_OK):
        return Path(runtime) / _NAME
    return Path(tempfile.gettempdir()) / f"{_NAME}-{os.getuid()}"


class Claim:
    """The claim of a device to its place.

    Parameters
    ----------
    device
        Name of the device, for messages.
    place
        What it is and where, such as `the arm at 192.168.1.10`; None where more than one program may use it, and nothing is done.
    """

    def __init__(self, device: str, place: str | None) -> None:
        self._device, self._place = device, place
        self._file: int | None = None
        self._folder = Path()

    def __enter__(self) -> Self:
        self.take()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()

    def take(self) -> None:
        """Take the place; raises NotReady where another has it, or its file cannot be had."""
        while self._place is not None and self._file is None:
            self._folder = claims_folder()
            file = self._locked(_name(self._place))
            if os.fstat(file).st_nlink:
                os.ftruncate(file, 0)
                os.pwrite(file, f"{os.getpid()}\n".encode(), 0)
                self._file = file
            else:  # its holder let go of it in this moment, and took the file away
                os.close(file)

    def release(self) -> None:
        """Let go of the place; may be called more than once."""
        file, self._file = self._file, None
        if file is not None and self._place is not None:
            with suppress(OSError):
                (self._folder / _name(self._place)).unlink()
            fcntl.flock(file, fcntl.LOCK_UN)  # a process that was forked meanwhile has the lock too
            os.close(file)

    def _locked(self, name: str) -> int:
        """Return the file of a name, locked."""
        try:
            file = _opened(self._folder, name)
        except OSError as error:
            reason = f"{self._folder}: {error.strerror or error}; {_remedy(self._folder)}"
            raise self._refused(f"its claim cannot be kept in {reason}") from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.pread(file, _LONGEST_PID, 0).decode("ascii", "replace").strip()
            os.close(file)
            raise self._refused(_in_use(holder)) from None
        return file

    def _refused(self, reason: str) -> NotReady:
        return NotReady(self._device, f"{self._place} is not to be had: {reason}")


def _name(place: str) -> str:
    return quote(place, safe=" ") + ".lock"


def _opened(folder: Path, name: str) -> int:
    """Return a file of a folder of our own, both made where they are not there; raises OSError."""
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    inside = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        status = os.fstat(inside)
        if status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & _NOT_OTHERS:
            raise PermissionError(0, "others can enter it")
        return os.open(name, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600, dir_fd=inside)
    finally:
        os.close(inside)


def _remedy(folder: Path) -> str:
    if folder.is_symlink():
        return "it is a link, which another user may have made; remove it"
    return "make it a folder of your own that nobody else can enter (chmod 700), or remove it"


def _in_use(holder: str) -> str:
    if holder == str(os.getpid()):
        return "this program has it open already; close the cell that has it first"
    if not holder:
        return "another program has it; wait for its end, or end it"
    return f"process {holder} has it; wait for its end, or end it with: kill -INT {holder}"
