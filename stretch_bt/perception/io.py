"""Depth frames from files: 16-bit PNG images and stacks in npz."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_path
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import DepthFrame, Intrinsics, as_reals
from stretch_bt.plain_numbers import is_number
from stretch_bt.source.arrays import load_arrays
from stretch_bt.source.bounds import MAX_IMAGE, read_bytes
from stretch_bt.source.png import check_png

__all__ = ["load_depth_png", "load_depth_stack"]


def load_depth_png(
    path: str | Path,
    *,
    unit: float,
    intrinsics: Intrinsics,
    time: float = 0.0,
    sequence: int = 0,
    plane_distance: float | None = None,
) -> DepthFrame:
    """Load a 16-bit grey PNG as counts of `unit` metres, 0 where invalid.

    Raises
    ------
    InvalidInput
        The file is no such image, or does not fit the intrinsics.
    """
    import cv2

    _check_unit(unit)
    check_path(path)
    try:
        data = read_bytes(Path(path), MAX_IMAGE)
    except OSError as error:
        raise InvalidInput(f"{path} cannot be read: {error.strerror}") from error
    check_png(str(path), data)
    encoded = np.frombuffer(data, dtype=np.uint8)
    raw = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED) if encoded.size else None
    if raw is None or raw.ndim != 2 or raw.dtype != np.uint16:
        found = "no image" if raw is None else f"{raw.dtype} {raw.shape}"
        raise InvalidInput(f"{path} holds {found}; a depth image is a 16-bit PNG with one channel")
    return DepthFrame(np.asarray(raw, dtype=np.uint16), unit, intrinsics, time, sequence, plane_distance)


def load_depth_stack(
    path: str | Path,
    *,
    unit: float,
    intrinsics: Intrinsics,
    key: str,
    times: str | Sequence[float],
    plane_distance: float | None = None,
) -> Iterator[DepthFrame]:
    """Yield the frames of an array `key` (n, h, w) uint16 in an npz file.

    `times`, s, is a sequence or the name of another array in the file. The file is checked before the first frame.

    Raises
    ------
    InvalidInput
        The file or array is missing or of another kind, or does not fit the intrinsics or the times.
    """
    _check_unit(unit)
    check_path(path)
    stack, stamps = _read_stack(path, key, times)
    if stack.ndim != 3 or stack.dtype != np.uint16:
        raise InvalidInput(
            f"{key!r} in {path} is {stack.dtype} {stack.shape}; a stack of depth images is uint16 (n, h, w)"
        )
    if len(stamps) != len(stack):
        raise InvalidInput(f"{path} has {len(stack)} frames and {len(stamps)} times")
    return (
        DepthFrame(raw, unit, intrinsics, float(time), number, plane_distance)
        for number, (raw, time) in enumerate(zip(stack, stamps, strict=True))
    )


def _check_unit(unit: float) -> None:
    if not (is_number(unit) and 1e-6 <= unit <= 1e-2):
        raise InvalidInput(f"unit is the depth of one count in metres, such as 0.000125, got {shown(unit)[:80]}")


def _read_stack(
    path: str | Path, key: str, times: str | Sequence[float]
) -> tuple[npt.NDArray[np.uint16], npt.NDArray[np.float64]]:
    wanted = [key, times] if isinstance(times, str) else [key]
    try:
        found = load_arrays(Path(path), wanted)
    except (OSError, TypeError) as error:
        raise InvalidInput(f"{path} is not an npz file that can be read: {error}") from error
    stamps = as_reals("times are", found[times] if isinstance(times, str) else times, "s")
    if stamps.ndim != 1:
        raise InvalidInput(f"times are one time for each frame, s, got an array of shape {stamps.shape}")
    return found[key], stamps
