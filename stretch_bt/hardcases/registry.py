"""Which hard cases there are."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import ModuleType

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases import domains
from stretch_bt.hardcases.hard import Hard
from stretch_bt.source import closest

__all__ = ["DOMAINS", "about", "case", "cases", "load"]

DOMAINS = (
    "membrane",
    "friction",
    "indenters",
    "balloons",
    "dough",
    "coupling",
    "camera",
    "scenes",
    "perception",
    "fits",
    "model",
    "runner",
)


@cache
def cases(domain: str) -> dict[str, Hard]:
    """Return the cases of a domain by their names.

    Raises
    ------
    InvalidInput
        There is no such domain; the text lists those that are.
    """
    if domain not in DOMAINS:
        near = closest(domain, DOMAINS)
        hint = f"; did you mean {near!r}?" if near else ""
        raise InvalidInput(f"there is no domain {domain!r} of hard cases; the domains are {', '.join(DOMAINS)}{hint}")
    return {hard.name: hard for hard in load(domain)}


def load(domain: str) -> tuple[Hard, ...]:
    """Return the cases of a domain in the order of its file."""
    found: tuple[Hard, ...] = _module(domain).CASES
    return found


def about(domain: str) -> str:
    """Return the subject of a domain, one sentence."""
    return " ".join((_module(domain).__doc__ or "").split("\n\n")[0].split())


def _module(domain: str) -> ModuleType:
    return import_module(f"{domains.__name__}.{domain}")


def case(domain: str, name: str) -> Hard:
    """Return the case at an address.

    Raises
    ------
    InvalidInput
        There is no such domain or name.
    """
    known = cases(domain)
    if name not in known:
        raise InvalidInput(
            f"there is no hard case {name!r} in {domain}; `stretch-bt hardcases --domain {domain}` lists them"
        )
    return known[name]
