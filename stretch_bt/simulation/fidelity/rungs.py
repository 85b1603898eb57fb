"""How finely a scene's sheet is solved: the settings that the advisor chooses from."""

from __future__ import annotations

from collections.abc import Mapping

from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["RUNGS", "USUAL_RUNG"]

#: that of a scene which says `fidelity: sheet`
USUAL_RUNG = "usual"
#: from the cheapest to the most accurate; all of them exact, so that no force depends on what was solved before it
RUNGS: Mapping[str, Settings] = {
    "coarse": Settings(coarsen=2.2, growth=2.0, corrected=False),
    "medium": Settings(coarsen=1.0, growth=1.8, corrected=False),
    USUAL_RUNG: Settings(),
    "fine": Settings(coarsen=0.8, growth=1.4),
}
