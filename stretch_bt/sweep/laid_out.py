"""The files of an item on the disk of its worker."""

from __future__ import annotations

import atexit
import hashlib
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import chdir, contextmanager
from pathlib import Path

__all__ = ["fresh_folder", "laid_out"]

#: by the digest of the files: where this process has them; the Python modules among them stay imported from there
_folders: dict[str, Path] = {}


def laid_out(files: Mapping[str, bytes]) -> Path:
    """Return the folder in which this process has some files, written when it is first asked for them."""
    digest = hashlib.sha256()
    for name, content in sorted(files.items()):
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    key = digest.hexdigest()
    if key not in _folders:
        folder = Path(tempfile.mkdtemp(prefix="stretch-sweep-")).resolve()
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        _write(files, folder)
        _folders[key] = folder
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


def _write(files: Mapping[str, bytes], folder: Path) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
