"""What a PNG file says of its size, before it is decoded."""

from __future__ import annotations

import struct

from stretch_bt.errors import InvalidInput
from stretch_bt.source.bounds import MAX_IMAGE, hold

__all__ = ["check_png"]

_BEGIN = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"
#: bytes of a pixel at most: four channels of 16 bits
_PIXEL = 8


def check_png(name: str, data: bytes) -> None:
    """Raise InvalidInput where the data of the file `name` are no PNG image, or one that would take more than `MAX_IMAGE`.

    Width and height are the first fields of the first chunk (PNG specification, 11.2.1).
    """
    end = len(_BEGIN) + 8
    if not data.startswith(_BEGIN) or len(data) < end:
        raise InvalidInput(f"{name} holds no image; a depth image is a 16-bit PNG with one channel")
    width, height = struct.unpack(">II", data[len(_BEGIN) : end])
    hold(f"{name}, an image of {width} x {height} pixels,", width * height * _PIXEL, MAX_IMAGE, "crop it")
