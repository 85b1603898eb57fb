"""Arrays of an npz file that a cell file names."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy.typing as npt

from stretch_bt.errors import DeviceLost, InvalidInput
from stretch_bt.hardware.driver import Mistake, missing_file
from stretch_bt.source import did_you_mean
from stretch_bt.source.arrays import array_names, check_arrays, load_arrays

__all__ = ["npz_mistakes", "read_arrays"]


def npz_mistakes(
    root: Path, option: str, file: str, keys: dict[str, str | None], begin: Callable[[], object]
) -> Iterator[Mistake]:
    """Yield what is wrong with a file, or with the array names that options give, by option, or else why its recording cannot begin."""
    path = root / file
    missing = list(missing_file(root, option, file))
    if missing:
        yield from missing
        return
    try:
        names = array_names(path)
        check_arrays(path, [key for key in keys.values() if key in names])
    except (OSError, InvalidInput) as error:
        yield option, str(error), "write one with numpy.savez"
        return
    unknown = {name: key for name, key in keys.items() if key is not None and key not in names}
    for name, key in unknown.items():
        yield name, f"{file!r} has no array {key!r}", did_you_mean(key, names)
    if unknown:
        return
    try:
        begin()
    except (DeviceLost, InvalidInput) as error:
        reason = error.reason if isinstance(error, DeviceLost) else str(error)
        yield option, reason, "name another array, or record it anew"


def read_arrays(device: str, path: Path, keys: list[str]) -> dict[str, npt.NDArray[Any]]:
    """Return arrays by name, read-only; raises DeviceLost when they cannot be read."""
    try:
        arrays = load_arrays(path, keys)
    except (OSError, InvalidInput) as error:
        raise DeviceLost(device, f"{path.name} cannot be read ({error})") from error
    for array in arrays.values():
        array.setflags(write=False)
    return arrays
