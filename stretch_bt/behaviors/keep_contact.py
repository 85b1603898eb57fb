"""Keeping contacts for a fit of them all."""

from stretch_bt.errors import NoContact
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, InOut, Status, port
from stretch_bt.tree.registry import node


@node
class KeepContact(Behavior):
    """Add a contact to the list in a key, or begin one; FAILURE when the contact does not know the pose of the hand.

    `fit_object` takes the list beside the cloud that `fuse_contact` makes of the same contacts. Past `most` the oldest
    one is dropped.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # contact from any pose of the hand
    most: In[int] = port(64, min=1, max=1000, doc="number of contacts to keep")
    reset: In[bool] = False  # whether to begin a new list
    contacts: InOut[list[Contact] | None]  # the list with this contact as the last

    def update(self) -> Status:
        """Keep."""
        if self.contact.pose is None:
            raise NoContact("the contact does not know the pose of the hand; use an arm beside the camera")
        known = [] if self.reset else self.contacts or []
        self.contacts = [*known, self.contact][-self.most :]
        return Status.SUCCESS
