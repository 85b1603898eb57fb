"""Where to press next."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import within_range
from stretch_bt.behaviors.records import Candidates, Felt, PlannedPress
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class PlanPress(Behavior):
    """Choose the press at which the object should reach the wanted deflection; FAILURE when no candidate is harder than the present one.

    The force never falls: it exceeds the last press' force by at least three standard deviations of the difference of the two. The hand
    presses deeper at the same stretch where that is enough, and else takes the next stretch at which the force is within reach. Where the
    deflection has reached `least`, a lack of harder presses is no FAILURE: `hardest` reports it, and the plan is the present press.
    """

    kind = "model"
    instant = True
    candidates: In[Candidates]  # presses to choose from, by `list_presses`
    felt: In[Felt]  # the object, as far as it was felt
    deflection: In[Length] = port(min=1e-4, doc="wanted deflection of the object")
    least: In[Length | None] = port(None, min=1e-4, doc="deflection that is enough where no candidate is harder")
    next: Out[PlannedPress]  # next press, at the present stretch where that is enough
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
            plan = felt.stay()
        self.next = PlannedPress.of(plan, given, known=self.hardest)
        return Status.SUCCESS
