"""How much memory the content of a file may take: a small file can unpack to more than a machine has.

Whoever reads something packed asks `hold` before it unpacks.
"""

from __future__ import annotations

from pathlib import Path

from stretch_bt.errors import InvalidInput

__all__ = ["MAX_ARRAYS", "MAX_CHUNK", "MAX_FORM", "MAX_IMAGE", "hold", "read_bytes"]

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

    A device such as /dev/zero never ends, so no more than the bound is taken from anything.
    """
    with path.open("rb") as stream:
        data = stream.read(most + 1)
    hold(str(path), len(data), most, "name another file")
    return data


def _said(size: int) -> str:
    power = min(max(size.bit_length() - 1, 0) // 10, len(_UNITS) - 1)
    return f"{size / 1024**power:.3g} {_UNITS[power]}"
