"""Text that says nothing of one machine: no address of a device, and of a path only the file's name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

__all__ = ["HOST", "Places", "usual_folders"]

#: stands for a device's address
HOST = "its host"
_ADDRESS = re.compile(r"\b\d{1,3}(?:\.\d{1,3}){3}\b", re.ASCII)
# a path begins where no word ends: neither the path of a node nor a unit such as N/mm is one
_BEGINS = r"(?<![\w.)\]/])"
_FOLDERS = re.compile(_BEGINS + r"/(?:[^\s/'\"(),;:<>]+/+)+")
# a host that looks like a plain word is left: it may be one
_LIKE_A_HOST = re.compile(r"[.:\d-]")


def usual_folders() -> list[str]:
    """Return the home of the user and the current folder, where there are any."""
    found = []
    for ask in (Path.home, Path.cwd):
        with suppress(OSError, RuntimeError):  # the user has none, or it was removed
            found.append(str(ask()))
    return found


class Places:
    """Takes the places of one machine out of the log of a run, so that the logs of two machines can be compared.

    Parameters
    ----------
    hosts
        Addresses of devices, beside those of four numbers.
    folders
        Absolute paths of folders, beside those that hold no space.
    """

    def __init__(self, hosts: Iterable[str] = (), folders: Iterable[str] = ()) -> None:
        known = [*(re.escape(host) for host in hosts if _LIKE_A_HOST.search(host)), _ADDRESS.pattern]
        self._hosts = re.compile(rf"(?<![\w/.-])(?:{'|'.join(known)})(?![\w/-])", re.ASCII)
        named = [re.escape(f"{folder.rstrip('/')}/") for folder in folders if folder.strip("/")]
        self._folders = [re.compile(f"{_BEGINS}(?:{'|'.join(named)})")] * bool(named) + [_FOLDERS]

    def without(self, text: str) -> str:
        """Return a text without them."""
        for folders in self._folders if "/" in text else ():
            text = folders.sub("", text)
        return self._hosts.sub(HOST, text)

    def left_out(self, value: Any) -> Any:
        """Return JSON's own types without them, keys aside."""
        if isinstance(value, str):
            return self.without(value)
        if isinstance(value, dict):
            return {name: self.left_out(item) for name, item in value.items()}
        return [self.left_out(item) for item in value] if isinstance(value, list) else value
