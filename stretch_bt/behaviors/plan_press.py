"""Where to press next."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.behaviors._readings import fitted
from stretch_bt.errors import IllConditioned
from stretch_bt.model.palpation.planning import Plan
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length


@node
class PlanPress(ModelBehavior):
    """Find the next press, at which the object should give way by the wanted drop; FAILURE when none within the limits is harder.

    It follows from the force model and the curve that `track_drop` fitted last. The force never falls: it is at least that of
    the last press and three standard deviations of what the two may be off. The hand presses deeper at the same stretch
    where that will do, and else takes the next stretch at which the force is within reach. Where the object gave way by `least` already,
    that none is harder is no FAILURE: `hardest` says it.
    """

    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    contact_height: In[Length] = port(doc="height from which depths count, as `approach` found it")
    drop: In[Length] = port(min=1e-4, doc="by which the object should give way")
    least: In[Length | None] = port(
        None, min=1e-4, doc="deflection that will do where no press within the limits is harder"
    )
    max_depth: In[Length] = port(0.018, min=0.001, max=0.030, doc="of the hand, past first contact", limit="depth")
    max_force: In[Force] = port(8.0, min=0.05, max=50.0, doc="by the model", limit="force")
    max_stretch: In[Length] = port(0.080, min=0.0, max=0.080, doc="of the membrane", limit="stretch")
    stretch_step: In[Length] = port(0.010, min=0.001, max=0.080, doc="between the stretches to choose from")
    stretch: Out[Length]  # at which to press; the present one where that will do
    depth: Out[Length]  # of the hand, past first contact
    force: Out[Force]  # expected there
    expected: Out[Length]  # drop expected there
    hardest: Out[bool]  # whether no press within the limits is harder than the present one, which the rest then tells

    def prepare(self) -> None:
        """Load the model, and refuse one that does not reach as far as is planned."""
        super().prepare()
        self.prepare_reach(lambda: self.max_stretch)

    def update(self) -> Status:
        """Plan."""
        found = fitted(self.context)
        if found is None:
            raise IllConditioned("nothing is known of the object yet; run 'track_drop' first")
        limits = mechanics.Limits(
            self.contact_height - self.max_depth, self.max_force, self.max_stretch, self.stretch_step
        )
        self.hardest = False
        try:
            with within_range():
                plan = mechanics.next_press(
                    self.force_model(), self.radius, found.series, found.last, self.drop, limits, needed=self.least
                )
        except mechanics.NoHarderPress:
            if self.least is None or found.series.drop.value < self.least:
                raise
            self.hardest = True
            plan = Plan(found.last.stretch, found.last.hand, found.series.force.value, found.series.drop.value)
        self.stretch, self.depth = plan.stretch, max(self.contact_height - plan.hand, 0.0)
        self.force, self.expected = plan.force, plan.drop
        return Status.SUCCESS
