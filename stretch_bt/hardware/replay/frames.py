"""Where recorded depth images come from: an npz archive or a folder of PNG files."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceLost, InvalidInput
from stretch_bt.source.bounds import MAX_IMAGE, read_bytes
from stretch_bt.source.png import check_png

__all__ = ["FrameArray", "FrameFolder", "Frames", "png_files"]

Counts = npt.NDArray[np.uint16]


class Frames(ABC):
    """Depth images in the order of their recording."""

    @abstractmethod
    def __getitem__(self, number: int) -> Counts:
        """Return one image, (h, w) uint16 counts."""


class FrameArray(Frames):
    """Images in one (n, h, w) uint16 array."""

    def __init__(self, device: str, images: npt.NDArray[Any], count: int, shape: tuple[int, int]) -> None:
        if images.dtype != np.uint16 or images.shape != (count, *shape):
            raise DeviceLost(
                device,
                f"the recording holds {images.dtype} images of shape {images.shape}; "
                f"its times and intrinsics ask for uint16 of shape {(count, *shape)}",
            )
        self._images = images

    def __getitem__(self, number: int) -> Counts:
        """Return one image."""
        image: Counts = self._images[number]
        return image


class FrameFolder(Frames):
    """One 16-bit PNG file an image, read when it is asked for."""

    def __init__(self, device: str, files: list[Path], shape: tuple[int, int]) -> None:
        self._device = device
        self._files = files
        self._shape = shape

    def __getitem__(self, number: int) -> Counts:
        """Return one image; raises DeviceLost when the file is not one that fits."""
        import cv2

        path = self._files[number]
        try:
            data = read_bytes(path, MAX_IMAGE)
            check_png(path.name, data)
        except (OSError, InvalidInput) as error:
            raise DeviceLost(self._device, f"{path.name} cannot be read as an image ({error})") from error
        image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise DeviceLost(self._device, f"{path.name} cannot be read as an image")
        if image.dtype != np.uint16 or image.shape != self._shape:
            found = f"{image.dtype} of shape {image.shape}"
            raise DeviceLost(self._device, f"{path.name} holds {found}; the intrinsics ask for uint16 of {self._shape}")
        return np.asarray(image, dtype=np.uint16)


def png_files(folder: Path) -> list[Path]:
    """Return the PNG files of a folder, numbers in their names in the order of counting."""

    def order(path: Path) -> list[tuple[int, int | str]]:
        return [(0, int(part)) if part.isdecimal() else (1, part) for part in re.split(r"(\d+)", path.stem) if part]

    return sorted(folder.glob("*.png"), key=order)
