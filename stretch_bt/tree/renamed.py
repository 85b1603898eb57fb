"""Names that nodes, and params of shipped trees, had in older versions: `check` and `--set` say what they are called now."""

from __future__ import annotations

__all__ = ["new_node", "renamed"]

#: by the old name of a node: the text to write now
_NODES = {
    "detect_hanging": "it is 'detect_adhesion' now, which gives 'adhering'",
    "next_state": "'plan_protocol' lists the presses that are left; go through them with 'for_each'",
    "plan_active": "write 'list_presses' and 'plan_look', which gives a record 'next'",
    "predict_hang": "it is 'predict_sag' now, which gives a record 'mounting'",
    "roundness": "it is 'measure_roundness' now; compare its outputs in a 'check'",
    "track_drop": "write 'add_reading' and 'fit_deflection', which gives a record 'felt'",
}

_PALPATION = {"drop": "wanted_deflection", "last_drop": "last_deflection", "hold": "min_hold"}
#: by the name of the tree's file: the old name of a param and the one of today
_PARAMS = {
    "palpate_stiffness": _PALPATION,
    "palpate_active": {**_PALPATION, "wanted": "wanted_error"},
    "form_cookie": {"settled": "settled_spread"},
    "reconstruct": {"depth": "max_depth", "coverage": "wanted_coverage", "max_drop": "max_deflection"},
}


def renamed(tree: str, param: str) -> str | None:
    """Return the present name of a param of a shipped tree, or None where it never had another name."""
    return _PARAMS.get(tree, {}).get(param)


#: words of other languages, and what does it here
_FOREIGN = {
    "for": "write 'for_each: {items: ..., as: $key, do: ...}'",
    "foreach": "write 'for_each: {items: ..., as: $key, do: ...}'",
    "loop": "write 'repeat: {times: ..., do: ...}', or 'until: {that: ..., max: ..., do: ...}'",
    "if": "write 'skip_if: ...' beside a node, or a 'selector' whose first child begins with a 'check'",
    "else": "write a 'selector': its next child runs where the one before failed",
    "fallback": "write 'selector'",
    "not": "write 'invert', or 'not' within the condition of a 'check'",
    "sleep": "write 'wait: {duration: ...}'",
}


def new_node(name: str) -> str | None:
    """Return what to write in place of an old node, or of a word of another language; None for any other name."""
    return _NODES.get(name) or _FOREIGN.get(name.lower())
