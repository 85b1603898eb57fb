"""How nodes look: a colour for each kind, a sign for each way of running children."""

from __future__ import annotations

from stretch_bt.tree.export.view import NodeView

__all__ = ["KINDS", "colour", "fill", "glyph", "legend", "sign"]

#: kind -> (what the legend calls it, colour of its band, colour of its ground)
KINDS = {
    "tree": ("tree", "#2f9e62", "#eefaf3"),
    "flow": ("flow", "#5b6675", "#f3f5f8"),
    "condition": ("condition", "#c77d0a", "#fff8ea"),
    "actuation": ("actuation", "#d1495b", "#fff1f2"),
    "perception": ("perception", "#2b6cb0", "#eef5fc"),
    "model": ("model", "#7a4fbf", "#f6f1fd"),
    "data": ("keys and results", "#8a94a3", "#fafbfc"),
}
_OTHER = ("other node", "#3b4452", "#ffffff")

_SIGNS = {
    "sequence": "→",
    "selector": "?",
    "parallel": "⇉",
    "reactive_sequence": "↻→",
    "reactive_selector": "↻?",
    "until": "↺",
    "repeat": "↺",
    "retry": "↺",
    "for_each": "↺",
    "invert": "¬",
}


def colour(kind: str) -> str:
    """Return the colour of a kind."""
    return KINDS.get(kind, _OTHER)[1]


def fill(kind: str) -> str:
    """Return the pale colour of a kind."""
    return KINDS.get(kind, _OTHER)[2]


def legend(kinds: set[str]) -> list[tuple[str, str]]:
    """Return (kind, name) of the kinds that a drawing uses."""
    known = [(kind, KINDS[kind][0]) for kind in KINDS if kind in kinds]
    return known + ([("other", _OTHER[0])] if kinds - set(KINDS) else [])


def glyph(view: NodeView) -> str:
    """Return the heading of a node: its sign, its name, and its kind when the name does not say it."""
    said = view.title in (view.keyword, view.keyword.rpartition(".")[2]) or view.keyword == "tree"
    return f"{sign(view)} {view.title}".lstrip() + ("" if said else f" ({view.keyword})")


def sign(view: NodeView) -> str:
    """Return the sign of how a node runs its children, or nothing."""
    return _SIGNS.get(view.keyword, "")
