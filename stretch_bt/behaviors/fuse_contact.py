"""Fusing contacts into a cloud."""

from stretch_bt import perception
from stretch_bt.perception.clouds.cloud import CELL, FLOOR, Cloud
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, InOut, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length


@node
class FuseContact(Behavior):
    """Add a contact to the cloud in a key, or begin one; FAILURE when the contact has too few points.

    Every node that writes to the same key adds to the same cloud. Contacts from frames with the hand's pose come together
    in the world; contacts without it, from a camera alone, in the frame of the hand, which then must not move.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # contact from any pose of the hand
    cell: In[Length] = port(CELL, min=1e-4, max=0.01, doc="width of the columns in which points are averaged")
    floor: In[Length] = port(FLOOR, min=0.0, max=0.01, doc="standard deviation that all points share, as of the pose")
    reset: In[bool] = False  # whether to begin a new cloud
    cloud: InOut[Cloud | None]  # the cloud with this contact in it

    def update(self) -> Status:
        """Fuse."""
        known = None if self.reset else self.cloud
        self.cloud = perception.fuse_contact(self.contact, known, cell=self.cell, floor=self.floor)
        return Status.SUCCESS
