"""Where to press next and how long to look."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import within_range
from stretch_bt.behaviors._readings import fixed_part, frames_at, noise_at
from stretch_bt.behaviors.records import Candidates, Felt, PlannedPress, TopReadings
from stretch_bt.errors import IllConditioned
from stretch_bt.model.palpation.active import Choice
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length, Time

LEAST_NOISE = 1e-6  # m


@node
class PlanLook(Behavior):
    """Choose the press and the number of frames that reduce the variance of the stiffness at a deflection most per second of the robot.

    The force never falls: the hand stays where it is, or presses harder by at least three standard deviations of the difference of the two forces.
    The plan is `known` when the stated deviation is as small as wanted, or no look reduces it enough; it is then the present press.
    While the object's deflection is not known yet, the press is planned as by `plan_press`; FAILURE when no candidate is harder.
    """

    kind = "model"
    instant = True
    candidates: In[Candidates]  # presses to choose from, by `list_presses`
    felt: In[Felt]  # the object, as far as it was felt
    top_readings: In[TopReadings]  # readings of its top
    deflection: In[Length] = port(
        min=1e-4, doc="deflection at which the stiffness is wanted; no press goes where it may be twice as large"
    )
    at_press: In[bool] = port(
        False, doc="whether the stiffness at the last press is wanted instead, whichever that will be"
    )
    wanted_error: In[float] = port(0.05, min=1e-3, max=1.0, doc="relative standard deviation of that stiffness")
    least_gain: In[float] = port(
        0.01, min=0.0, max=10.0, doc="least relative reduction of the variance, per second, that is worth a look"
    )
    settle: In[Time] = port(0.0, min=0.0, max=60.0, doc="time for which a new press is left alone before a look")
    frame_noise: In[Length | None] = port(
        None,
        min=1e-6,
        max=0.01,
        doc="standard deviation of a height's error in one frame; unless given, as the present press' readings state",
    )
    next: Out[PlannedPress]  # next press; the present one where the hand stays

    def update(self) -> Status:
        """Plan."""
        felt = self.felt
        choice = None if self._known(felt) else self._choice(felt)
        plan = (None if choice is None else choice.press) or felt.stay()
        count, gain = (min(mechanics.COUNTS), 0.0) if choice is None else (choice.count, choice.gain)
        self.next = PlannedPress.of(plan, self.candidates, count, gain, known=choice is None)
        return Status.SUCCESS

    def _known(self, felt: Felt) -> bool:
        """Return whether the stiffness is known as well as is wanted."""
        try:
            stiffness = felt.series.stiffness() if self.at_press else felt.stiffness_at(self.deflection)
        except IllConditioned:
            return False
        return stiffness.sd <= self.wanted_error * stiffness.value

    def _noise(self, felt: Felt) -> tuple[Length, Length]:
        """Return the standard deviation of a height's error in one frame, m, and the part that more frames do not reduce, m."""
        if self.frame_noise:
            return self.frame_noise, fixed_part(self.frame_noise)
        noise, fixed = noise_at(self.top_readings.readings, felt.last)
        return max(noise, LEAST_NOISE), fixed

    def _choice(self, felt: Felt) -> Choice | None:
        given = self.candidates
        noise, fixed = self._noise(felt)
        taken = float(frames_at(self.top_readings.readings, felt.last))
        with within_range():
            return mechanics.next_look(
                given.model,
                given.radius,
                felt.series,
                felt.last,
                self.deflection,
                given.limits,
                mechanics.Looks(noise, fixed, mechanics.ROBOT, taken),
                mechanics.Costs(settle=self.settle),
                least=self.least_gain,
                at_press=self.at_press,
            )
