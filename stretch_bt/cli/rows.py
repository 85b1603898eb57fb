"""Rows of tables for people, whose texts are shown as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["add_row"]


def add_row(table: Table, *cells: str) -> None:
    """Add texts, in which brackets and colons mean nothing to the table, as in `list[float]`."""
    from rich.text import Text

    table.add_row(*(Text(cell) for cell in cells))
