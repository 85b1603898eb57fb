"""The files that a sweep needs, its own and those that they name, gathered so that another machine can lay them out again."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from stretch_bt.errors import FileError, InvalidInput, SweepError
from stretch_bt.source import Scalar, Value, parse, walk

__all__ = ["Bundle"]

#: bytes of all files; each item carries them
MOST_BYTES = 64_000_000
#: characters of a text that may be the name of a file
LONGEST_NAME = 255


class Bundle:
    """Files by their place relative to the folder of the sweep file, each with those that it names.

    A file is named where a text of a YAML file is the path of a file relative to the folder of that file, or to the folder of the
    sweep file: trees and modules that are imported, scenes, meshes, calibrations, models. Shipped files are not taken: a
    worker has them.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(os.path.normpath(folder.absolute()))
        self._content: dict[Path, bytes] = {}
        self._named: dict[Path, list[Path]] = {}
        self._shipped = Path(str(files("stretch_bt"))).resolve()

    def add(self, path: Path | str) -> dict[str, str]:
        """Take a file and all that it names, and return their digests, by their paths relative to the folder of the sweep file.

        Raises
        ------
        SweepError
            A file names another by an absolute path.
        InvalidInput
            The files are too large to be handed around.
        """
        reached = self._reached(Path(os.path.normpath(self.folder / path)))
        return {self.name(file): hashlib.sha256(self._content[file]).hexdigest() for file in sorted(reached)}

    def add_named(self, text: str) -> dict[str, str]:
        """Take the file that a text names relative to the folder of the sweep file, if it names any."""
        path = self._file(text, self.folder)
        return {} if path is None else self.add(path)

    def name(self, path: Path | str) -> str:
        """Return the path of a file relative to the folder of the sweep file."""
        return Path(os.path.relpath(self.folder / path, self.folder)).as_posix()

    @property
    def above(self) -> Path:
        """The folder of this machine that all files lie below."""
        return Path(os.path.commonpath([self.folder, *(path.parent for path in self._content)]))

    def layout(self) -> tuple[dict[str, bytes], str]:
        """Return the content of all files by their paths below one folder, and the folder of the sweep file among them."""
        above = self.above
        found = {path.relative_to(above).as_posix(): content for path, content in self._content.items()}
        return found, self.folder.relative_to(above).as_posix()

    def _reached(self, path: Path) -> set[Path]:
        """Return a file that is taken and all that it leads to."""
        found, ahead = set[Path](), [path]
        while ahead:
            file = ahead.pop()
            if file not in found:
                found.add(file)
                ahead += self._take(file)
        return found

    def _take(self, path: Path) -> list[Path]:
        """Read a file unless that was done, and return the files that it names."""
        if path not in self._content:
            self._content[path] = path.read_bytes()
            if sum(map(len, self._content.values())) > MOST_BYTES:
                what = f"the files of the sweep have more than {MOST_BYTES // 1_000_000} MB, and each item carries them"
                raise InvalidInput(f"{path}: {what}; take a coarser mesh, or install the data with a package")
            self._named[path] = list(self._names(path))
        return self._named[path]

    def _names(self, path: Path) -> Iterator[Path]:
        if path.suffix not in (".yaml", ".yml"):
            return
        try:
            root: Value = parse(self._content[path].decode("utf-8"), str(path))
        except (FileError, UnicodeDecodeError):  # no file of ours, then: a node may read it
            return
        for _, value in walk(root):
            if isinstance(value, Scalar):
                self._check_relative(value)
                found = [self._file(value.text, folder) for folder in dict.fromkeys((path.parent, self.folder))]
                yield from (file for file in found if file is not None and file != path)

    def _file(self, text: str, folder: Path) -> Path | None:
        """Return the file that a text names, unless that is a shipped one."""
        if not _may_be_name(text) or Path(text).is_absolute():
            return None
        path = Path(os.path.normpath(folder / text))
        try:
            return path if path.is_file() and not path.resolve().is_relative_to(self._shipped) else None
        except OSError:
            return None

    @staticmethod
    def _check_relative(value: Scalar) -> None:
        if _may_be_name(value.text) and Path(value.text).is_absolute() and Path(value.text).is_file():
            message = f"{value.text!r} is an absolute path, which a worker on another machine may not have"
            raise SweepError([value.mark.error("value", message, "write a path relative to this file")])


def _may_be_name(text: str) -> bool:
    return 0 < len(text) <= LONGEST_NAME and text.isprintable()
