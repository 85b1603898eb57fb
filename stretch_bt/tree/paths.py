"""The path of every place of a tree: the same for the builder, mocks, records and drawings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from stretch_bt.tree.flow.base import Part

__all__ = ["Paths"]


class Paths:
    """Gives paths from the root down; same labels in one place are distinguished by [0], [1] ..."""

    def __init__(self) -> None:
        self._tables: dict[str, dict[int, str]] = {}

    def root(self, part: Part, base: str) -> str:
        """Return the path of the body of a tree, whose nodes are called by `base`."""
        return self._table([part], base)[id(part)]

    def child(self, owner: Part, part: Part, path: str) -> str:
        """Return the path of a child of the part at `path`."""
        if owner.opens_path:
            return self._table(owner.children(), path)[id(part)]
        return self._tables[path.rpartition("/")[0]][id(part)]

    def _table(self, parts: Sequence[Part], base: str) -> dict[int, str]:
        if base not in self._tables:
            together = [p for part in parts for p in _namespace(part)]
            count = Counter(p.label for p in together)
            used: Counter[str] = Counter()
            table = self._tables[base] = {}
            for part in together:
                index = f"[{used[part.label]}]" if count[part.label] > 1 else ""
                used[part.label] += 1
                table[id(part)] = f"{base}/{part.label}{index}"
        return self._tables[base]


def _namespace(part: Part) -> Iterator[Part]:
    """Yield the parts that share one path prefix: a part, and all inside it that it does not name."""
    yield part
    if not part.opens_path:
        for child in part.children():
            yield from _namespace(child)
