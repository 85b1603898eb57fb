"""Names of params that shipped trees had in older versions, so that `--set` with one says what it is called now."""

from __future__ import annotations

__all__ = ["renamed"]

_PALPATION = {"drop": "wanted_deflection", "last_drop": "last_deflection", "hold": "min_hold"}
#: by the name of the tree's file: the old name of a param and the one of today
_PARAMS = {
    "palpate_stiffness": _PALPATION,
    "palpate_active": _PALPATION,
    "form_cookie": {"settled": "settled_spread"},
    "reconstruct": {"depth": "max_depth", "coverage": "wanted_coverage"},
}


def renamed(tree: str, param: str) -> str | None:
    """Return what a param of a shipped tree is called now, or None where it never had another name."""
    return _PARAMS.get(tree, {}).get(param)
