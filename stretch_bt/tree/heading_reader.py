"""What every reader of headings does: notes mistakes at their places, lists the entries of a mapping, judges names."""

from __future__ import annotations

import re

from stretch_bt.source import Map, Mark, Scalar, Value
from stretch_bt.tree.document import Document
from stretch_bt.tree.expression import FUNCTIONS

__all__ = ["HeadingReader"]

RESERVED = ("params", "task", "none", "true", "false", "and", "or", "not")


class HeadingReader:
    """Reads a part of the headings of a file; every mistake is noted, none stops the reading of the rest."""

    def __init__(self, doc: Document) -> None:
        self.doc = doc

    def error(self, mark: Mark, code: str, message: str, hint: str = "") -> None:
        """Note a mistake."""
        self.doc.diagnostics.append(mark.error(code, message, hint))

    def entries(self, value: Value | None, what: str) -> list[tuple[Scalar, Value]]:
        """Return the entries of a mapping; none where it is left out, or is something else."""
        if value is None or (isinstance(value, Scalar) and value.value is None):
            return []
        if not isinstance(value, Map):
            self.error(value.mark, "type-mismatch", f"{what} takes a mapping", f"write '{what}: {{name: ...}}'")
            return []
        return list(value.pairs)

    def good_name(self, key: Scalar, what: str) -> bool:
        """Whether something may have this name."""
        reserved = (*RESERVED, *(FUNCTIONS if what in ("param", "key") else ()))
        if re.fullmatch(r"[A-Za-z_]\w*", key.text, re.ASCII) and key.text not in reserved:
            return True
        message = f"{key.text!r} cannot be the name of a {what}"
        self.error(key.mark, "name", message, "use letters a to z, digits and _, no reserved word")
        return False
