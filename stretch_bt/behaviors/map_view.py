"""Adding a press to the map of an object."""

from __future__ import annotations

from stretch_bt import perception
from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.clouds.cloud import CELL, Cloud
from stretch_bt.perception.clouds.relief import Relief, add_view, carved
from stretch_bt.perception.clouds.seen import view_of
from stretch_bt.perception.clouds.stand_off import with_stand_off
from stretch_bt.perception.clouds.views import contact_of, surface_of
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, InOut, Status
from stretch_bt.tree.registry import node


@node
class MapView(Behavior):
    """Distinguish contact from free membrane by the surface that stays as the hand rises, and add the contact to a map and a cloud.

    FAILURE when the press disagrees with earlier ones by more than noise explains: the object moved or gave way. Map, cloud
    and contacts are then left as they were.
    """

    kind = "perception"
    instant = True
    deep: In[DepthFrame]  # frame with the hand lowered
    shallow: In[DepthFrame]  # frame with the hand raised a little, still in contact
    relief: InOut[Relief | None]  # the map with this press in it
    cloud: InOut[Cloud | None]  # points in contact, without points that later presses undercut
    contacts: InOut[list[Contact] | None]  # contacts of the presses that touched, to fit the shape to all of them

    def update(self) -> Status:
        """Add."""
        deep, shallow = self.deep, self.shallow
        if deep.pose is None or shallow.pose is None:
            raise InvalidInput("the frames do not say where the hand was; declare an arm")
        geometry = self.context.hand.geometry
        half = 0.5 * (geometry.gauge + (deep.stretch or 0.0))
        surface = surface_of(deep)
        view = view_of(surface, surface_of(shallow), deep_pose=deep.pose, shallow_pose=shallow.pose, half_length=half)
        relief = add_view(view, self.relief)
        before = self.cloud
        contact = contact_of(deep, surface, view, relief)
        cloud = before if contact is None else perception.fuse_contact(contact, before, cell=CELL)
        self.relief = relief
        if cloud is not None:
            self.cloud = with_stand_off(carved(cloud, relief), relief)
        if contact is not None:
            self.contacts = [*(self.contacts or []), contact]
        return Status.SUCCESS
