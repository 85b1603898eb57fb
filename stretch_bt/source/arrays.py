"""Arrays of npy and npz files, of which the size is known, and bounded, before anything is unpacked.

Objects are never unpickled. Of the ways to pack a zip file only numpy's are read: a reader of the others
cannot be given a limit.
"""

from __future__ import annotations

import errno
import io
import math
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from stretch_bt.errors import InvalidInput
from stretch_bt.source.bounds import MAX_ARRAYS, hold, open_file
from stretch_bt.source.suggest import did_you_mean

__all__ = ["array_names", "check_arrays", "load_array", "load_arrays", "unread_array"]

Array = npt.NDArray[Any]

#: characters of a header, as numpy bounds them
_HEADER = 10_000
_PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_HEADERS = {(1, 0): ("<H", npy.read_array_header_1_0), (2, 0): ("<I", npy.read_array_header_2_0)}
#: exceptions of zipfile, zlib and numpy on files that are damaged or were made to do harm
_BROKEN = (
    ValueError,
    TypeError,
    LookupError,
    EOFError,
    RuntimeError,
    OverflowError,
    SyntaxError,
    struct.error,
    tokenize.TokenError,
    zlib.error,
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
)
#: kinds of numpy's types: truths, whole numbers with and without sign, floats
_NUMBERS = "biuf"
_REMEDY = "split the recording, or leave out what is not needed"


def load_arrays(path: Path, names: Iterable[str]) -> dict[str, Array]:
    """Return arrays of an npz file by name.

    Raises
    ------
    OSError
        The file cannot be read.
    InvalidInput
        It is no npz file, lacks an array, is damaged, or would take more than `MAX_ARRAYS`; the text names it.
    """
    with _opened(path) as archive:
        return {name: _unpacked(path, archive, entry) for name, entry in _checked(path, archive, names).items()}


def check_arrays(path: Path, names: Iterable[str]) -> None:
    """Raise what `load_arrays` would, as far as it can be known without unpacking."""
    with _opened(path) as archive:
        _checked(path, archive, names)


def array_names(path: Path) -> list[str]:
    """Return the names of the arrays in an npz file; raises OSError or InvalidInput."""
    with _opened(path) as archive:
        return list(_entries(archive))


def unread_array(path: Path, name: str) -> Array:
    """Return an array of zeros, which takes no memory, of the shape and type of one of an npz file; raises as `load_arrays` does."""
    with _opened(path) as archive, archive.open(_checked(path, archive, [name])[name]) as stream:
        shape, dtype, _ = _header(stream)
        return np.broadcast_to(np.zeros((), dtype), shape)


def load_array(path: Path, most: int = MAX_ARRAYS) -> Array:
    """Return the array of an npy file of at most so many bytes; raises as `load_arrays` does."""
    with _told(path, "npy"), open_file(path) as stream:
        size = _size(stream)
        hold(str(path), size, most, "sample it more coarsely")
        if path.stat().st_size < size:
            raise EOFError(f"it ends after {path.stat().st_size} of {size} bytes")
        stream.seek(0)
        return _read(stream)


@contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    with _told(path, "npz"), open_file(path) as stream:
        if stream.read(npy.MAGIC_LEN).startswith(npy.MAGIC_PREFIX):
            raise ValueError("it holds one array, as an npy file")
        with zipfile.ZipFile(stream) as archive:
            yield archive


@contextmanager
def _told(path: Path, kind: str) -> Iterator[None]:
    """Turn whatever a broken file raises into InvalidInput that names it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numpy warns of headers that it can read all the same
            yield
    except InvalidInput:
        raise
    except _BROKEN as error:
        raise _unreadable(path, kind, str(error) or type(error).__name__) from error
    except OSError as error:
        if error.errno != errno.EINVAL or error.filename is not None:
            raise
        # a place before the begin of the file, to which a damaged table of contents points
        raise _unreadable(path, kind, "its table of contents is damaged") from error


def _unreadable(path: Path, kind: str, why: str) -> InvalidInput:
    return InvalidInput(f"{path} is not an {kind} file that can be read: {why}")


def _entries(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    return {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}


def _checked(path: Path, archive: zipfile.ZipFile, names: Iterable[str]) -> dict[str, zipfile.ZipInfo]:
    """Return the entries of arrays whose headers say that all of them together are not too large."""
    entries, wanted, total = _entries(archive), list(dict.fromkeys(names)), 0
    for name in wanted:
        if name not in entries:
            raise InvalidInput(f"{path} has no array {name!r}; {did_you_mean(name, entries)}")
        entry = entries[name]
        if entry.compress_type not in _PACKED:
            raise InvalidInput(
                f"{path}: array {name!r} is packed in a way that numpy does not use; write it with numpy.savez"
            )
        with archive.open(entry) as stream:
            size = _size(stream)
        total += max(size, entry.file_size)
        hold(f"{path} with array {name!r}", total, MAX_ARRAYS, _REMEDY)
        if entry.file_size < size:
            raise InvalidInput(f"{path}: array {name!r} ends after {entry.file_size} of {size} bytes")
    return {name: entries[name] for name in wanted}


def _unpacked(path: Path, archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> Array:
    with _told(path, "npz"), archive.open(entry) as stream:
        return _read(stream)


def _read(stream: IO[bytes]) -> Array:
    return np.asarray(npy.read_array(stream, allow_pickle=False, max_header_size=_HEADER))


def _size(stream: IO[bytes]) -> int:
    """Return how many bytes an array has with its header; raises ValueError where it is none, or of objects."""
    shape, dtype, begin = _header(stream)
    content: int = math.prod(shape) * dtype.itemsize
    return begin + content


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    """Return shape and type of an array, and where it begins; raises ValueError where it is none, or of objects."""
    version = npy.read_magic(stream)
    if version not in _HEADERS:
        raise ValueError(f"its version {version} is not read; write it with numpy.save")
    form, read = _HEADERS[version]
    start = _exactly(stream, struct.calcsize(form))
    (length,) = struct.unpack(form, start)
    if length > _HEADER:
        raise ValueError(f"its header has {length} bytes, which no array needs")
    shape, _, dtype = read(io.BytesIO(start + _exactly(stream, length)), max_header_size=_HEADER)
    if dtype.kind not in _NUMBERS or dtype.itemsize == 0:
        raise ValueError(f"it holds {dtype}, not numbers")
    if any(side < 0 for side in shape):
        raise ValueError(f"its shape is {shape}")
    return shape, dtype, npy.MAGIC_LEN + len(start) + length


def _exactly(stream: IO[bytes], count: int) -> bytes:
    data = stream.read(count)
    if len(data) < count:
        raise EOFError("it ends in its header")
    return data
