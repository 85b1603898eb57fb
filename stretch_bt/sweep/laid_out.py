"""The files of an item on the disk of its worker."""

from __future__ import annotations

import atexit
import hashlib
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import chdir, contextmanager
from pathlib import Path
from types import ModuleType

from stretch_bt.errors import InvalidInput

__all__ = ["fresh_folder", "laid_out", "stand_at"]

#: by the digest of the files: where this process has them; the Python modules among them stay imported from there
_folders: dict[str, Path] = {}


def stand_at(files: Mapping[str, bytes], folder: Path) -> None:
    """Say that some files stand in a folder of this machine: this process may have imported the Python modules there."""
    _folders[_digest(files)] = folder.resolve()


def laid_out(files: Mapping[str, bytes]) -> Path:
    """Return the folder in which this process has some files, written when it is first asked for them.

    Raises
    ------
    InvalidInput
        Python modules of other files were imported under the same names, or a file was changed where it stands.
    """
    key = _digest(files)
    if key not in _folders:
        _check_imported(files)
        folder = Path(tempfile.mkdtemp(prefix="stretch-sweep-")).resolve()
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        _write(files, folder)
        _folders[key] = folder
    for name, content in files.items():
        if (_folders[key] / name).read_bytes() != content:
            raise InvalidInput(f"{_folders[key] / name} was changed while the sweep ran; run it again with --resume")
    return _folders[key]


@contextmanager
def fresh_folder(files: Mapping[str, bytes], home: str) -> Iterator[Path]:
    """Work in an empty place with a copy of some files, so that no item sees what another wrote; yield a folder beside it."""
    with tempfile.TemporaryDirectory(prefix="stretch-item-") as name:
        folder = Path(name)
        _write(files, folder / "files")
        here = folder / "files" / home
        here.mkdir(parents=True, exist_ok=True)
        with chdir(here):
            yield folder


def _check_imported(files: Mapping[str, bytes]) -> None:
    """Refuse modules that a sweep before this one brought in another text: a process imports each name once."""
    names = {part for name in files if name.endswith(".py") for part in Path(name).with_suffix("").parts}
    for name in sorted(names & sys.modules.keys()):
        places = [Path(place) for place in _places(sys.modules[name])]
        if any(place.is_relative_to(folder) for place in places for folder in _folders.values()):
            what = f"this worker has imported another {name!r}, of an earlier sweep"
            raise InvalidInput(f"{what}; restart the workers, and go on with --resume")


def _places(module: ModuleType) -> list[str]:
    """Return the file of a module, and the folders of a package, which may have no file."""
    return [str(place) for place in (getattr(module, "__file__", None), *getattr(module, "__path__", ())) if place]


def _digest(files: Mapping[str, bytes]) -> str:
    digest = hashlib.sha256()
    for name, content in sorted(files.items()):
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _write(files: Mapping[str, bytes], folder: Path) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
