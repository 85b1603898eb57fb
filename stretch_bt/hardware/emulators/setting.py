"""What the processes of the stand-ins around one scene have in common."""

from __future__ import annotations

import time
from dataclasses import dataclass

__all__ = ["Setting"]


@dataclass(frozen=True)
class Setting:
    """A scene's file or name, the seed, and when the scene's clock was 0, s of this machine's."""

    scene: str
    seed: int
    begun: float

    def now(self) -> float:
        """Return the time of the scene, s."""
        return time.monotonic() - self.begun
