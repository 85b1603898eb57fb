"""The arrays of mocks: in `.npy` and `.npz` files beside a mocks file, or in memory; a record keeps those that its run used."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
import numpy.typing as npt

from stretch_bt.brief import brief
from stretch_bt.errors import InvalidInput
from stretch_bt.source import Mark, Scalar, Value, did_you_mean
from stretch_bt.source.arrays import array_names, load_array, load_arrays
from stretch_bt.tree.types import unaliased
from stretch_bt.tree.values import refuse

__all__ = ["ARRAYS", "MockArrays", "array_fields", "array_of", "names_array"]

#: name of the file of the arrays in a record
ARRAYS = "mocks.npz"

SUFFIXES = (".npy", ".npz")

Array = npt.NDArray[Any]


def names_array(value: Value) -> TypeGuard[Scalar]:
    """Whether a value of a mocks file is the name of an array."""
    return isinstance(value, Scalar) and Path(value.text.partition("#")[0]).suffix in SUFFIXES


class MockArrays:
    """Finds arrays by the text that names them: `depth.npy`, `views.npz#deep`, or `views.npz` where that holds one alone.

    Parameters
    ----------
    folder
        Folder in which the paths begin.
    held
        Arrays that are in memory, by the text that names them.
    """

    def __init__(self, folder: Path, held: Mapping[str, Array] | None = None) -> None:
        self.folder = folder
        self.held = dict(held or {})
        self._used: dict[str, Array] = {}

    @classmethod
    def of_record(cls, record: Path, folder: Path) -> MockArrays:
        """Return those that a record keeps; raises OSError or InvalidInput where they cannot be read."""
        path = record / ARRAYS
        return cls(folder, load_arrays(path, array_names(path)) if path.exists() else None)

    def read(self, value: Value, dtype: np.dtype[Any] | None, what: str) -> Array:
        """Return the array that a value of a mocks file stands for: one that it names, or nested lists of SI numbers.

        Raises
        ------
        ValueRefused
            There is none, or it does not hold what is wanted; the diagnostic says where and what to write.
        """
        found = self._named(value, what) if isinstance(value, Scalar) else value.plain()
        return array_of(found, dtype, what, value.mark)

    def numbers(self, value: Scalar, what: str, deep: int = 1) -> list[Any]:
        """Return the entries, or with `deep` 2 the rows, of an array of SI numbers that a text names; raises ValueRefused."""
        found = self.read(value, None, what)
        if found.ndim != deep or found.dtype.kind not in "biuf" or not np.isfinite(found).all():
            message = (
                f"{what} takes finite numbers in an array of {deep} dimension{'s' * (deep > 1)}, not {brief(found)}"
            )
            refuse(value.mark, "type-mismatch", message, "select a part of it")
        entries: list[Any] = found.tolist()
        return entries

    def save(self, record: Path) -> None:
        """Write the arrays that were read into the folder of a record, where there are any."""
        if self._used:
            np.savez(record / ARRAYS, **self._used)  # type: ignore[arg-type]  # no array is called allow_pickle

    def _named(self, value: Scalar, what: str) -> Array:
        name = value.text
        if name not in self.held:
            self.held[name] = self._loaded(value, what)
        self._used[name] = self.held[name]
        return self.held[name]

    def _loaded(self, value: Scalar, what: str) -> Array:
        file, _, entry = value.text.partition("#")
        path = self.folder / file
        if path.suffix not in SUFFIXES or (entry and path.suffix == ".npy"):
            hint = "name a file beside this one, as in 'depth.npy' or 'views.npz#deep', or write nested lists"
            refuse(value.mark, "type-mismatch", f"{what} takes an array, not {value.text!r}", hint)
        try:
            return load_array(path) if path.suffix == ".npy" else self._of_npz(path, entry)
        except OSError as error:
            hint = did_you_mean(file, _beside(path)) or "write the path from this file"
            refuse(value.mark, "file-missing", f"{what}: {file!r} cannot be read: {error.strerror or error}", hint)
        except InvalidInput as error:
            message, _, hint = str(error).partition("; ")
            refuse(value.mark, "value", f"{what}: {message}", hint)

    @staticmethod
    def _of_npz(path: Path, entry: str) -> Array:
        names = array_names(path)
        if not entry and len(names) != 1:
            raise InvalidInput(f"{path.name} holds {', '.join(names)}; say which, as in '{path.name}#{names[0]}'")
        return load_arrays(path, [entry or names[0]])[entry or names[0]]


def _beside(path: Path) -> list[str]:
    return sorted(p.name for p in path.parent.glob("*.np[yz]")) if path.parent.is_dir() else []


def array_of(given: Any, dtype: np.dtype[Any] | None, what: str, mark: Mark) -> Array:
    """Return an array, or nested lists of SI numbers, as an array of a type.

    Raises
    ------
    ValueRefused
        It holds something else.
    """
    found = given if isinstance(given, np.ndarray) else _nested(given, what, mark)
    if dtype is None or found.dtype == dtype:
        return found
    made = found.astype(dtype)
    if not np.array_equal(made, found, equal_nan=made.dtype.kind == "f" and found.dtype.kind == "f"):
        refuse(mark, "type-mismatch", f"{what} takes an array of {dtype}, not of {found.dtype}", "convert it")
    return made


def _nested(given: Any, what: str, mark: Mark) -> Array:
    try:
        found = np.array(given)
    except ValueError:  # rows of several lengths
        found = np.array(None)
    if found.dtype.kind not in "biuf":
        refuse(mark, "type-mismatch", f"{what} takes an array", "write lists of SI numbers, each row of one length")
    return found


@lru_cache(maxsize=256)
def array_fields(cls: type) -> Mapping[str, np.dtype[Any] | None]:
    """Return the fields of a dataclass that are arrays, each with its type where the annotation names one."""
    hints = typing.get_type_hints(cls) if dataclasses.is_dataclass(cls) else {}
    return {name: _dtype(found) for name, hint in hints.items() if (found := _array_hint(hint)) is not None}


def _array_hint(hint: Any) -> Any:
    """Return the part of an annotation that is of an array, also where it may be None."""
    hint = unaliased(hint)
    parts = typing.get_args(hint) if type(None) in typing.get_args(hint) else (hint,)
    arrays = (unaliased(part) for part in parts)
    return next((part for part in arrays if np.ndarray in (part, typing.get_origin(part))), None)


def _dtype(hint: Any) -> np.dtype[Any] | None:
    inner = typing.get_args(typing.get_args(hint)[1]) if len(typing.get_args(hint)) > 1 else ()
    concrete = inner and isinstance(inner[0], type) and inner[0] not in (np.generic, np.floating, np.integer)
    return np.dtype(inner[0]) if concrete else None
