"""Who commands a motion: the path of a node."""

from __future__ import annotations

from typing import Any

from stretch_bt.errors import InvalidInput, shown

__all__ = ["check_owner"]


def check_owner(device: str, owner: Any) -> None:
    """Raise InvalidInput for an owner that does not read as the path of a node: a record with it could not be read."""
    if not (isinstance(owner, str) and owner.isprintable() and all(part.strip() for part in owner.split("/"))):
        told = f"a motion's owner is the path of the node that commands it, not {shown(owner)}"
        raise InvalidInput(f"{device}: {told}; write owner=self.path")
