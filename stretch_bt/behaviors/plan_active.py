"""Where to press next and how long to look."""

from stretch_bt import model as mechanics
from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.behaviors._readings import Fitted, Reading, fitted, fixed_part, frames_at, noise_at
from stretch_bt.errors import IllConditioned
from stretch_bt.model.palpation.active import Choice
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed, Time

LEAST_NOISE = 1e-6  # m


@node
class PlanActive(ModelBehavior):
    """Find the press and the number of frames that take most off the variance of the stiffness at a drop per second of the robot.

    They follow from the force model and the curve that `track_drop` fitted last. The force never falls: the hand stays where it is, or
    presses harder by at least three standard deviations of what the two may be off. `done` when the stated deviation is as small as
    wanted, or no look takes enough off it; stretch and depth are then those of the present press. While the object's drop is not
    told yet the press is that of `plan_press`; FAILURE when none within the limits is harder.
    """

    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    contact_height: In[Length] = port(doc="height from which depths count, as `approach` found it")
    drop: In[Length] = port(min=1e-4, doc="at which the stiffness is to be told; it is not passed by twice")
    at_press: In[bool] = port(False, doc="tell that at the last press instead, whichever that will be")
    wanted: In[float] = port(0.05, min=1e-3, max=1.0, doc="standard deviation of that stiffness, as a part of it")
    least_gain: In[float] = port(
        0.01, min=0.0, max=10.0, doc="part of the variance per second below which no look is worth its time"
    )
    max_depth: In[Length] = port(0.018, min=0.001, max=0.030, doc="of the hand, past first contact", limit="depth")
    max_force: In[Force] = port(8.0, min=0.05, max=50.0, doc="by the model", limit="force")
    max_stretch: In[Length] = port(0.080, min=0.0, max=0.080, doc="of the membrane", limit="stretch")
    stretch_step: In[Length] = port(0.010, min=0.001, max=0.080, doc="between the stretches to choose from")
    press_speed: In[Speed] = port(0.005, min=0.0005, max=0.050, doc="of the hand")
    change_time: In[Time] = port(3.5, min=0.0, max=60.0, doc="of leaving the object, stretching and coming back")
    frame_time: In[Time] = port(1 / 30, min=1e-3, max=1.0, doc="of one frame")
    settle: In[Time] = port(0.0, min=0.0, max=60.0, doc="for which a new press is left alone before it is looked at")
    frame_noise: In[Length | None] = port(
        None,
        min=1e-6,
        max=0.01,
        doc="by which a height is off in one frame; unless given, as the readings of the present press say",
    )
    robot_sd: In[Length] = port(
        mechanics.ROBOT, min=0.0, max=0.001, doc="by which the hand stands off where it is sent"
    )
    stretch: Out[Length]  # at which to press
    depth: Out[Length]  # of the hand, past first contact
    count: Out[int]  # frames to average there
    gain: Out[float]  # part of the variance that this should take away, per second; 0 when done
    done: Out[bool]  # whether the stiffness is known well enough, or as well as is worth the time

    def prepare(self) -> None:
        """Load the model, and refuse one that does not reach as far as is planned."""
        super().prepare()
        self.prepare_reach(lambda: self.max_stretch)

    def update(self) -> Status:
        """Plan."""
        found = fitted(self.context)
        if found is None:
            raise IllConditioned("nothing is known of the object yet; run 'track_drop' first")
        choice = None if self._known(found) else self._choice(found)
        press = choice.press if choice is not None else None
        self.stretch = press.stretch if press is not None else found.last.stretch
        self.depth = max(self.contact_height - (press.hand if press is not None else found.last.hand), 0.0)
        self.count = choice.count if choice is not None else min(mechanics.COUNTS)
        self.gain = choice.gain if choice is not None else 0.0
        self.done = choice is None
        return Status.SUCCESS

    def _known(self, found: Fitted) -> bool:
        """Return whether the stiffness is known as well as is wanted."""
        try:
            stiffness = found.series.stiffness() if self.at_press else found.series.stiffness_at(self.drop)
        except IllConditioned:
            return False
        return stiffness.sd <= self.wanted * stiffness.value

    def _noise(self, press: Reading) -> tuple[Length, Length]:
        """Return by how much a height is off in one frame, m, and what of it more frames leave, m."""
        if self.frame_noise:
            return self.frame_noise, fixed_part(self.frame_noise)
        noise, fixed = noise_at(self.context, press)
        return max(noise, LEAST_NOISE), fixed

    def _choice(self, found: Fitted) -> Choice | None:
        noise, fixed = self._noise(found.last)
        with within_range():
            return mechanics.next_look(
                self.force_model(),
                self.radius,
                found.series,
                found.last,
                self.drop,
                mechanics.Limits(
                    self.contact_height - self.max_depth, self.max_force, self.max_stretch, self.stretch_step
                ),
                mechanics.Looks(noise, fixed, self.robot_sd, float(frames_at(self.context, found.last))),
                mechanics.Costs(self.press_speed, self.change_time, self.frame_time, self.settle),
                least=self.least_gain,
                at_press=self.at_press,
            )
