"""The texts that Python modules were imported from: a module stays as it was, whatever becomes of its file."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from importlib.machinery import ModuleSpec
from pathlib import Path

__all__ = ["digest_of_file", "imported_digest", "note_imported", "stands_in"]

#: by the name of a module, the specs that it was imported by, another one for each reload, each with the digest of the text
_digests: dict[str, list[tuple[ModuleSpec | None, str | None]]] = {}


def imported_digest(name: str, file: Path) -> str | None:
    """Return the SHA-256 of the text that a module was imported from, of its file where none was; None where it cannot be read.

    The text of a module is read when this is first asked for, or when `note_imported` comes across it.
    """
    if name not in sys.modules:
        return digest_of_file(file)
    spec = getattr(sys.modules[name], "__spec__", None)
    known = _digests.setdefault(name, [])
    if not any(one is spec for one, _ in known):
        known.append((spec, digest_of_file(file)))
    return next(digest for one, digest in known if one is spec)


def note_imported(folders: Iterable[str]) -> None:
    """Keep the digests of the modules that were imported from some folders, each once, while their files are as they were."""
    for folder in folders:
        for name, module in list(sys.modules.items()):
            file = str(getattr(module, "__file__", None) or "")
            own = file.startswith(folder + os.sep) and file.endswith(".py")
            if own and stands_in(Path(file), Path(folder), name.partition(".")[0]):
                imported_digest(name, Path(file))


def stands_in(file: Path, home: Path, top: str) -> bool:
    """Whether a module, or the package that it belongs to, stands in a folder; the folder may also be the one of this package."""
    return top != __name__.partition(".")[0] and (file.parent == home or file.is_relative_to(home / top))


def digest_of_file(file: Path) -> str | None:
    """Return the SHA-256 of a file, None where it cannot be read."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return None
