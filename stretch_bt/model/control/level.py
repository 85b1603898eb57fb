"""Keeping the force on a lump that rolls under the hand."""

from __future__ import annotations

__all__ = ["LOST", "MOST_STEP", "PATIENCE", "STIFFNESS", "ForceKeeper"]

STIFFNESS = (
    600.0  # N/m, above the stiffness of the hand on a lump, so that the height creeps to where the force is right
)
MOST_STEP = 0.0015  # m; largest change of the height in one step
LOST = 0.1  # part of the wanted force; with less at the greatest depth nothing is under the hand
PATIENCE = 8  # steps in a row, a lap, after which it is gone


class ForceKeeper:
    """Moves the height of the hand, m, so that the force that it feels goes towards the wanted one."""

    def __init__(self, height: float) -> None:
        self.height = height
        self._missed = 0

    @property
    def is_lost(self) -> bool:
        """Whether next to nothing was felt for a whole lap where the hand may not go lower."""
        return self._missed >= PATIENCE

    def keep(self, wanted: float, felt: float, lowest: float) -> None:
        """Move the height by the force that the hand felt, N, but never below `lowest`, m."""
        missed = self.height <= lowest and felt < LOST * wanted
        self._missed = self._missed + 1 if missed else 0
        if not self.is_lost:
            step = min(max((wanted - felt) / STIFFNESS, -MOST_STEP), MOST_STEP)
            self.height = max(self.height - step, lowest)
