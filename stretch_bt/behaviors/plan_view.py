"""Choosing where to press next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from stretch_bt.behaviors._motion import MOST_DEPTH
from stretch_bt.behaviors._views import Place, counted, place_of, request_of
from stretch_bt.behaviors.records import PlannedView, TriedViews
from stretch_bt.errors import UnsetKey
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.perception.clouds.coverage import Hidden, coverage, hidden
from stretch_bt.perception.clouds.next_view import next_view
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.seen import turn_of
from stretch_bt.tree.ports import Behavior, In, InOut, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class PlanView(Behavior):
    """Choose the place and turn of the hand for the next press of an object: where the most surface not felt yet is expected.

    With `poses` the operator chooses the places. The view is `done` at the wanted coverage, when no pose is expected
    to show more than a little, when three presses in a row showed nothing new, or after the last of the poses. The first press
    is where the hand is.
    """

    kind = "perception"
    instant = True
    arm: Uses[Arm]
    gripper: Uses[Gripper | None]
    relief: In[Relief | None] = None  # map of the presses, none before the first press
    depth: In[Length] = port(0.015, min=0.001, max=MOST_DEPTH, doc="depth of the hand below the highest place felt")
    wanted_coverage: In[float] = port(0.95, min=0.0, max=1.0, doc="share of the upper surface that is enough")
    max_presses: In[int] = port(12, min=1, max=1000, doc="number of presses after which no other is planned")
    presses: In[int] = port(0, min=0, doc="number of presses made so far")
    poses: In[Sequence[str]] = ()  # poses, each `x; y` or `x; y; turn`, such as `10 mm; 0 mm; 90 deg`
    tried: InOut[TriedViews | None]  # the places that were planned
    view: Out[PlannedView]  # where to press next

    def prepare(self) -> None:
        """Refuse, where they are known already, poses that cannot be read."""
        with suppress(UnsetKey):
            for text in self.poses:
                place_of(text)

    def update(self) -> Status:
        """Plan."""
        relief, now = self.relief, self.arm.pose(PLACE).value
        here = (now.position[0], now.position[1], turn_of(now))
        left = None if relief is None else hidden(relief)
        unseen = 0.0 if relief is None or left is None else float(left.chance.sum()) * relief.cell**2
        share = 0.0 if relief is None or left is None else coverage(relief, left)
        place: Place | None
        if self.poses:
            place = self._asked_for()
        elif relief is None or left is None:
            place = here
        else:
            place = self._planned(relief, left, share, unseen)
        request = request_of(place) if self.poses and place is not None else ""
        self.view = PlannedView(*(place or here), request, share, unseen, place is None)
        return Status.SUCCESS

    def _asked_for(self) -> Place | None:
        """Return the place that the operator asked for; None after the last."""
        count = self.presses
        return place_of(self.poses[count]) if count < min(len(self.poses), self.max_presses) else None

    def _planned(self, relief: Relief, left: Hidden, share: float, unseen: float) -> Place | None:
        """Return the place that should show most; None where enough is known, or nothing shows more."""
        if share >= self.wanted_coverage or self.presses >= self.max_presses:
            return None
        known = float(left.told.sum()) * relief.cell**2
        self.tried = tried = counted(self.tried or TriedViews(), self.presses, known, unseen)
        if tried.is_fruitless:
            return None
        place = self._best(relief, left, tried.places)
        if place is not None:
            self.tried = replace(tried, places=(*tried.places, place))
        return place

    def _best(self, relief: Relief, left: Hidden, tried: Sequence[Place]) -> Place | None:
        geometry, limits = self.context.hand.geometry, self.context.limits
        stretch = 0.0 if self.gripper is None else geometry.stretch(self.gripper.opening(PLACE).value)
        anywhere = (-math.inf, math.inf)
        look = next_view(
            relief,
            depth=self.depth,
            length=geometry.gauge + stretch,
            width=geometry.width / math.sqrt(1.0 + stretch / geometry.gauge),
            x=anywhere if limits is None else (limits.x.min, limits.x.max),
            y=anywhere if limits is None else (limits.y.min, limits.y.max),
            unseen=left,
            tried=list(tried),
        )
        return None if look is None else (look.x, look.y, look.yaw)
