"""Memory in which the twin's process leaves pictures for the camera's."""

from __future__ import annotations

import mmap
import os
from typing import Final

import numpy as np
import numpy.typing as npt

__all__ = ["Pictures", "picture_memory"]

#: a picture is written over after this many more, 0.1 s at 30 Hz; a reader copies it in a millisecond
_SLOTS: Final = 4
#: the largest picture, pixels
_LARGEST: Final = 640 * 480

Picture = npt.NDArray[np.float32]


def picture_memory() -> int:
    """Return a descriptor of memory for pictures that processes can share."""
    descriptor = os.memfd_create("pictures")
    os.ftruncate(descriptor, 4 * _SLOTS * _LARGEST)
    return descriptor


class Pictures:
    """Pictures of one shape in shared memory.

    Parameters
    ----------
    descriptor
        File descriptor of the memory; it is closed.
    shape
        Rows and columns.
    """

    def __init__(self, descriptor: int, shape: tuple[int, int]) -> None:
        memory = mmap.mmap(descriptor, 4 * _SLOTS * _LARGEST)
        os.close(descriptor)
        rows, columns = shape
        every = np.frombuffer(memory, np.float32)
        self._slots = [every[_LARGEST * k :][: rows * columns].reshape(shape) for k in range(_SLOTS)]
        self._count = 0

    def put(self, picture: Picture) -> int:
        """Leave a (h, w) float32 picture, and return its number."""
        self._count += 1
        self._slots[self._count % _SLOTS][:] = picture
        return self._count

    def get(self, number: int) -> Picture:
        """Return a copy of the (h, w) float32 picture of a number."""
        return self._slots[number % _SLOTS].copy()
