"""One tree, read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from stretch_bt.source import Mark
from stretch_bt.tree.document import Signature
from stretch_bt.tree.flow import Call, Part

__all__ = ["TreeBody"]


@dataclass(slots=True, eq=False)
class TreeBody:
    """One tree, read: its body, its `finally`, and who writes each key."""

    signature: Signature
    part: Part
    finish: Part | None
    writers: dict[str, list[tuple[str, Mark]]] = field(default_factory=dict)

    def parts(self) -> Iterator[Part]:
        """Yield every part of the body and of `finally`."""
        yield from self.part.walk()
        if self.finish is not None:
            yield from self.finish.walk()

    def calls(self) -> Iterator[Call]:
        """Yield the calls of other trees."""
        return (p for p in self.parts() if isinstance(p, Call))
