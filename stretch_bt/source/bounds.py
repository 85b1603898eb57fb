"""How much memory the content of a file may take: a small file can unpack to more than a machine has.

Whoever reads something packed asks `hold` before it unpacks.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO, cast

from stretch_bt.errors import InvalidInput

__all__ = ["MAX_ARRAYS", "MAX_CHUNK", "MAX_FORM", "MAX_IMAGE", "hold", "open_file", "read_bytes"]

#: bytes of the arrays that are read from one file: three minutes of 640 x 480 depth images at 30 a second
MAX_ARRAYS = 4 << 30
#: bytes of one image, packed or decoded: 8 megapixels of four channels, where the largest of a RealSense camera has 0.9 of one
MAX_IMAGE = 64 << 20
#: bytes of one chunk of a record; a recorder begins a new one after 1 MiB
MAX_CHUNK = 64 << 20
#: bytes of a file that is read as a whole, such as a calibration, a force model or a height field
MAX_FORM = 64 << 20

_UNITS = ("B", "KiB", "MiB", "GiB", "TiB")


def hold(what: str, size: int, most: int, remedy: str) -> None:
    """Raise InvalidInput where something would take more bytes than `most`; `what` names its file."""
    if size > most:
        raise InvalidInput(f"{what} would take {_said(size)}, and at most {_said(most)} are read; {remedy}")


def read_bytes(path: Path, most: int = MAX_FORM) -> bytes:
    """Return the bytes of a file that is no larger than `most`; raises OSError where it is missing, or InvalidInput.

    A file may grow while it is read, so no more than the bound is taken from anything.
    """
    with open_file(path) as stream:
        data = stream.read(most + 1)
    hold(str(path), len(data), most, "name another file")
    return data


def open_file(path: Path) -> BinaryIO:
    """Open a file for reading; raises OSError at once for a pipe or device, to which nobody may ever write."""
    stream = cast(BinaryIO, open(path, "rb", opener=_without_waiting))  # noqa: SIM115
    if stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
        return stream
    stream.close()
    raise OSError(errno.EINVAL, "it is a pipe or a device, not a file; save it as a file first", str(path))


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _said(size: int) -> str:
    power = min(max(size.bit_length() - 1, 0) // 10, len(_UNITS) - 1)
    return f"{size / 1024**power:.3g} {_UNITS[power]}"
