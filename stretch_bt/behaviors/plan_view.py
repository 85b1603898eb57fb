"""Choosing where to press next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress

from stretch_bt.behaviors._motion import MOST_DEPTH
from stretch_bt.errors import InvalidInput, UnsetKey
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.perception.clouds.coverage import Hidden, coverage, hidden
from stretch_bt.perception.clouds.next_view import next_view
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.seen import turn_of
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import KINDS, Angle, Area, Length, parse_quantity

MAX_AGE = 0.5
FRUITLESS = 0.02  # share of what is told by which a press must change the map to count
PATIENCE = 3  # presses in a row that do not


@node
class PlanView(Behavior):
    """Choose the place and turn of the hand for the next press of an object: where most is expected that was not felt yet.

    With `poses` the operator says where. Nothing is left when so much is covered as was asked for, when no pose is expected
    to show more than a little, when three presses in a row showed nothing new, or when the poses are over. The first press
    is where the hand is.
    """

    kind = "perception"
    instant = True
    arm: Uses[Arm]
    gripper: Uses[Gripper | None]
    relief: In[Relief | None] = None  # what was felt, nothing before the first press
    depth: In[Length] = port(0.015, min=0.001, max=MOST_DEPTH, doc="of the hand below the highest place felt")
    wanted: In[float] = port(0.95, min=0.0, max=1.0, doc="share of the upper surface that is enough")
    max_presses: In[int] = port(12, min=1, max=1000, doc="after which no other is planned")
    presses: In[int] = port(0, min=0, doc="made so far")
    poses: In[Sequence[str]] = ()  # each `x; y` or `x; y; turn`, such as `10 mm; 0 mm; 90 deg`
    done: Out[bool]  # whether nothing is left; x, y and yaw are then where the hand is
    x: Out[Length]  # of the hand, world
    y: Out[Length]  # of the hand, world
    yaw: Out[Angle]  # turn of the hand about the vertical
    request: Out[str]  # what an operator is asked to confirm; empty where the pose was planned
    coverage: Out[float]  # share of the upper surface that is told; what is hidden counts as likely as it is there
    unseen: Out[Area]  # upper surface that is likely there and is not told, as seen from above

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.before: tuple[int, float, float] | None = None  # views, area told and unseen
        self.fruitless = 0
        self.tried: list[tuple[float, float, float]] = []

    def prepare(self) -> None:
        """Refuse, where they are known already, poses that cannot be read."""
        with suppress(UnsetKey):
            for text in self.poses:
                pose_of(text)

    def update(self) -> Status:
        """Plan."""
        relief, now = self.relief, self.arm.pose(MAX_AGE).value
        count = self.presses
        here = (now.position[0], now.position[1], turn_of(now))
        left = None if relief is None else hidden(relief)
        unseen = 0.0 if relief is None or left is None else float(left.chance.sum()) * relief.cell**2
        share = 0.0 if relief is None or left is None else coverage(relief, left)
        self.coverage, self.unseen = share, unseen
        pose: tuple[float, float, float] | None
        if self.poses:
            pose = pose_of(self.poses[count]) if count < min(len(self.poses), self.max_presses) else None
        elif relief is None or left is None:
            pose = here
        elif (
            share >= self.wanted
            or count >= self.max_presses
            or self._gave_up(count, float(left.told.sum()) * relief.cell**2, unseen)
        ):
            pose = None
        else:
            pose = self._planned(relief, left)
        self.done = pose is None
        self.x, self.y, self.yaw = x, y, yaw = here if pose is None else pose
        place = f"x {x * 1e3:.4g} mm, y {y * 1e3:.4g} mm, turned by {math.degrees(yaw):.4g} deg"
        self.request = f"The hand is about to press at {place}." if self.poses and pose is not None else ""
        return Status.SUCCESS

    def _planned(self, relief: Relief, left: Hidden) -> tuple[float, float, float] | None:
        geometry, limits = self.context.hand.geometry, self.context.limits
        stretch = 0.0 if self.gripper is None else geometry.stretch(self.gripper.opening(MAX_AGE).value)
        anywhere = (-math.inf, math.inf)
        look = next_view(
            relief,
            depth=self.depth,
            length=geometry.gauge + stretch,
            width=geometry.width / math.sqrt(1.0 + stretch / geometry.gauge),
            x=anywhere if limits is None else (limits.x.min, limits.x.max),
            y=anywhere if limits is None else (limits.y.min, limits.y.max),
            unseen=left,
            tried=self.tried,
        )
        if look is None:
            return None
        self.tried.append((look.x, look.y, look.yaw))
        return self.tried[-1]

    def _gave_up(self, count: int, told: float, unseen: float) -> bool:
        """Tell whether the latest presses changed nothing."""
        if self.before is not None and count > self.before[0]:
            change = abs(told - self.before[1]) + abs(unseen - self.before[2])
            self.fruitless = self.fruitless + 1 if change < FRUITLESS * told else 0
        self.before = (count, told, unseen)
        return self.fruitless >= PATIENCE


def pose_of(text: str) -> tuple[float, float, float]:
    """Return x, y, m, and turn, rad, of a pose as text; raises InvalidInput when it is none."""
    parts = [part.strip() for part in text.replace(";", ",").split(",")]
    if len(parts) not in (2, 3):
        raise InvalidInput(f"poses: {text!r} is not 'x; y' or 'x; y; turn', such as '10 mm; 0 mm; 90 deg'")
    found = [parse_quantity(part) for part in parts]
    for part, (_, dimension), kind in zip(parts, found, ("Length", "Length", "Angle"), strict=False):
        if dimension != KINDS[kind].dimension:
            raise InvalidInput(
                f"poses: {part!r} in {text!r} has another unit than it takes, as in '10 mm; 0 mm; 90 deg'"
            )
    x, y, *turn = (value for value, _ in found)
    return x, y, turn[0] if turn else 0.0
