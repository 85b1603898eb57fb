"""What is said of a value past a limit of the cell, before a motion and while it goes on."""

from __future__ import annotations

from stretch_bt.quantity_text import format_apart
from stretch_bt.units import KINDS

__all__ = ["outside_limits", "past_limit", "remedy"]


def past_limit(name: str, value: float, most: float, kind: str) -> str:
    """Return the message about a value above its limit, both SI, of a kind such as `Length`."""
    asked, allowed = format_apart(KINDS[kind], value, most)
    return f"{name} {asked} is past the limit of the cell, at most {allowed}"


def outside_limits(name: str, value: float, least: float, most: float) -> str:
    """Return the message about a length, m, outside its limits."""
    asked, low, high = format_apart(KINDS["Length"], value, least, most)
    return f"{name} {asked} is past the limits of the cell, {low} to {high}"


def remedy(limit: str) -> str:
    """Return what to do about a command past a limit, by the name that the cell file has for it."""
    return f"; ask for a value within, or change `{limit}` under `limits` in the cell file"
