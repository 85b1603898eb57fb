"""Where to press next."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import within_range
from stretch_bt.behaviors.records import Candidates, Felt, PlannedPress
from stretch_bt.model.palpation.planning import Plan
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class PlanPress(Behavior):
    """Choose the press at which the object should give way by the wanted deflection; FAILURE when no candidate is harder than the present one.

    The force never falls: it is at least that of the last press and three standard deviations of what the two may be off. The hand
    presses deeper at the same stretch where that will do, and else takes the next stretch at which the force is within reach. Where the
    object gave way by `least` already, that none is harder is no FAILURE: `hardest` says it, and the plan is the present press.
    """

    kind = "model"
    instant = True
    candidates: In[Candidates]  # by `list_presses`
    felt: In[Felt]  # the object, as far as it was felt
    deflection: In[Length] = port(min=1e-4, doc="by which the object should give way")
    least: In[Length | None] = port(None, min=1e-4, doc="deflection that will do where no candidate is harder")
    next: Out[PlannedPress]  # at the present stretch where that will do
    hardest: Out[bool]  # whether no candidate is harder than the present press

    def update(self) -> Status:
        """Plan."""
        given, felt = self.candidates, self.felt
        self.hardest = False
        try:
            with within_range():
                plan = mechanics.next_press(
                    given.model, given.radius, felt.series, felt.last, self.deflection, given.limits, needed=self.least
                )
        except mechanics.NoHarderPress:
            if self.least is None or felt.deflection < self.least:
                raise
            self.hardest = True
            plan = Plan(felt.last.stretch, felt.last.hand, felt.force, felt.deflection)
        depth = max(given.touched_at - plan.hand, 0.0)
        self.next = PlannedPress(plan.stretch, depth, plan.force, plan.drop, 0, 0.0, self.hardest)
        return Status.SUCCESS
