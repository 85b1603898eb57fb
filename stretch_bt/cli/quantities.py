"""Quantities that a command is given as text."""

from __future__ import annotations

from stretch_bt.errors import InvalidInput
from stretch_bt.units import KINDS

__all__ = ["quantity_of"]


def quantity_of(option: str, kind: str, text: str) -> float:
    """Return a quantity, SI; raises InvalidInput, which names the option."""
    try:
        return KINDS[kind].parse(text)
    except InvalidInput as error:
        raise InvalidInput(f"{option}: {error}") from None
