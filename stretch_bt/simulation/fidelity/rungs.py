"""How finely a scene's sheet is solved: the settings that the advisor chooses from."""

from __future__ import annotations

from collections.abc import Mapping

from stretch_bt.simulation.membrane.sheet.settings import Settings

__all__ = ["RUNGS", "USUAL_RUNG"]

#: setting of a scene which says `fidelity: sheet`
USUAL_RUNG = "usual"
#: from the cheapest to the most accurate; all of them exact and corrected, so that no force depends on earlier solves:
#: without the correction of the soft contact that dependence was 7e-4 of the force
RUNGS: Mapping[str, Settings] = {
    "coarse": Settings(coarsen=1.8, growth=1.8),
    USUAL_RUNG: Settings(),
    "fine": Settings(coarsen=0.8, growth=1.4),
}
