"""The files of an item on the disk of its worker."""

from __future__ import annotations

import atexit
import hashlib
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import chdir, contextmanager
from pathlib import Path

from stretch_bt.sweep.own_copies import refuse_changed

__all__ = ["fresh_folder", "laid_out"]

#: by the digest of the files: where this process has them
_folders: dict[str, Path] = {}


def laid_out(files: Mapping[str, bytes]) -> Path:
    """Return the folder in which this process has some files, written when it is first asked for them, and where a node changed them.

    Raises
    ------
    InvalidInput
        An earlier sweep imported Python modules of the same names in another text.
    """
    key = _digest(files)
    if key not in _folders:
        refuse_changed(files)
        _folders[key] = Path(tempfile.mkdtemp(prefix="stretch-sweep-")).resolve()
        atexit.register(shutil.rmtree, _folders[key], ignore_errors=True)
    folder = _folders[key]
    _write({name: content for name, content in files.items() if not _holds(folder / name, content)}, folder)
    return folder


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


def _digest(files: Mapping[str, bytes]) -> str:
    digest = hashlib.sha256()
    for name, content in sorted(files.items()):
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _holds(path: Path, content: bytes) -> bool:
    return path.is_file() and path.read_bytes() == content


def _write(files: Mapping[str, bytes], folder: Path) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
