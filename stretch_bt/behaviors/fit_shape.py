"""Fitting a shape to a contact."""

from typing import Literal

from stretch_bt import perception
from stretch_bt.perception.types import Contact, Shape
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node


@node
class FitShape(Behavior):
    """Fit a plane, sphere, cylinder or cone to the points in contact, or the one that explains them best."""

    kind = "perception"
    instant = True
    contact: In[Contact]  # points and rays of the contact
    shape: In[Literal["auto", "plane", "sphere", "cylinder", "cone"]] = port("auto", doc="shape to fit; auto compares")
    shape_fit: Out[Shape]  # the shape, its parameters with their deviations, and how all compare

    def update(self) -> Status:
        """Fit."""
        contact = self.contact
        self.shape_fit = perception.fit_shape(
            contact.points, rays=contact.rays, noise=contact.surface_noise, shape=self.shape
        )
        return Status.SUCCESS
