"""Rolling the object under the hand."""

from typing import Literal

from stretch_bt.behaviors._force import along_hand
from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._limited_motion import LimitedMotion
from stretch_bt.behaviors._motion import MOST_DEPTH, lowest_of, touched_at
from stretch_bt.behaviors._rolling import laid, length_of
from stretch_bt.behaviors.records import Touch
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, ForceSensor, Motion
from stretch_bt.model.control.level import ForceKeeper
from stretch_bt.tree.ports import In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed

STEPS = 72  # poses a turn: the chord misses a circle by a thousandth of the radius
LEGS = 8  # pieces of a lap after each of which the height follows the force


@node
class Roll(LimitedMotion):
    """Press to a depth and roll the object under the hand along a closed path that begins and ends where it stands.

    With a `force` the hand goes higher or lower after each eighth of a lap, down to `depth` at most, until the force along
    its axis equals it; else it stays at the depth. It makes `laps` laps, or rolls until it is stopped. FAILURE when the force
    exceeds its limit, or, with a `force`, when nothing was under the hand for a whole lap.
    """

    arm: Uses[Arm]
    force_sensor: Uses[ForceSensor | None]
    touch: In[Touch]  # first contact, from which depths count
    shape: In[Literal["circle", "eight"]] = "circle"  # a circle, or an eight along the stretch, 0.4 as wide as long
    radius: In[Length] = port(
        0.015, min=0.001, max=0.060, doc="radius of the circle, or half of the length of the eight", limit="radius"
    )
    speed: In[Speed] = port(0.030, min=0.001, max=0.250, doc="speed along the path", limit="contact_speed")
    depth: In[Length] = port(
        0.005, min=-0.030, max=MOST_DEPTH, doc="depth past first contact; with a force the largest", limit="depth"
    )
    force: In[Force | None] = port(None, min=0.01, max=50.0, doc="force to keep along the hand's axis", limit="force")
    max_force: In[Force] = port(18.0, min=0.05, max=50.0, doc="force above which to stop and fail", limit="held_force")
    laps: In[int] = port(1, min=0, max=100000, doc="number of laps; 0: until it is stopped")
    travel: Out[Length]  # travel of the hand so far, written after each piece
    mean_force: Out[Force]  # mean force along its axis over the latest piece

    def initialise(self) -> None:
        """Forget an earlier roll."""
        super().initialise()
        self.done = 0  # pieces
        self.rolled = 0.0
        self.readings: list[float] = []

    def start(self) -> Motion:
        """Follow the first piece."""
        self.limit = ForceLimit(self.max_force, self.arm, self.force_sensor, self.context)
        self.begin = self.arm.pose(PLACE).value
        self.keeper = ForceKeeper(self.begin.height if self.force is not None else self._lowest)
        return self._follow()

    @property
    def _lowest(self) -> float:
        return max(touched_at(self.context, self.touch) - self.depth, lowest_of(self.context))

    @property
    def _pieces(self) -> int:
        return 1 if self.force is None else LEGS

    def _follow(self) -> Motion:
        """Follow the next piece: a lap, or a leg of it where the height follows the force."""
        pieces = self._pieces
        part = self.done % pieces / pieces
        start = self.begin.at_height(self.keeper.height)
        poses = laid(self.shape, self.radius, start, part, part + 1 / pieces, STEPS // pieces)
        self.length = length_of(poses)
        self.readings = []
        return self.arm.follow(poses, speed=self.speed, owner=self.path)

    def watch(self) -> Status | None:
        """Stop at the limit of force."""
        ended = super().watch()
        self.readings.append(float(along_hand(self.limit.latest, self.begin)))  # it stays turned as at the beginning
        return ended

    def arrived(self) -> Status:
        """Go on with the next piece, or end with the last lap."""
        if (super().watch() if self.readings else self.watch()) is not None:  # of a quick piece there is no reading
            return Status.FAILURE
        self.done += 1
        self.rolled += self.length
        self.travel, self.mean_force = self.rolled, (felt := sum(self.readings) / len(self.readings))
        if self.force is not None:
            self.keeper.keep(self.force, felt, self._lowest)
        if self.keeper.is_lost:
            self.reason = f"nothing is under the hand any more: {felt:.2f} N at the greatest depth"
            return Status.FAILURE
        if self.laps and self.done >= self.laps * self._pieces:
            return Status.SUCCESS
        self.motion = self._follow()
        return Status.RUNNING
