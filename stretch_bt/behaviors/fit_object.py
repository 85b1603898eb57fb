"""Fitting the shape of an object."""

from typing import Literal

from stretch_bt import perception
from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.told import told_points
from stretch_bt.perception.solids.agree import outside
from stretch_bt.perception.solids.conformity import FILLET, FILLET_SD
from stretch_bt.perception.solids.result import DIMENSIONS, Solid
from stretch_bt.perception.solids.wire import no_wire_there
from stretch_bt.perception.types import Contact
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Length

Wanted = Literal[
    "auto", "block", "disc", "ridge", "half_cylinder", "domes", "point", "wire_circle", "wire_triangle", "extents"
]


@node
class FitObject(Behavior):
    """Fit the shape of an object on the table to the contacts felt on it; FAILURE when it cannot be measured.

    Dimensions that the shape does not have are `none`: a block has length, width and height, domes have the radius of
    each, the largest first.
    """

    kind = "perception"
    instant = True
    cloud: In[Cloud]  # cloud of the contacts, fused
    contacts: In[list[Contact]]  # contacts that the cloud was fused from, with the pose of the hand
    shape: In[Wanted] = port("auto", doc="shape to take for granted; auto takes the one with most evidence")
    relief: In[Relief | None] = None  # map of the presses; surface that it shows beside the contacts is added
    fillet: In[Length] = port(FILLET, min=1e-4, max=0.01, doc="radius of the object's edges, or of its wire")
    fillet_sd: In[Length] = port(FILLET_SD, min=0.0, max=0.01, doc="standard deviation of fillet")
    solid: Out[Solid] = port(
        truth={name: name for name in DIMENSIONS}, doc="the shape, with the dimensions that it has"
    )
    filled_cloud: Out[Cloud]  # cloud with the map's surface, less places that the shape leaves free, as inside a wire

    def update(self) -> Status:
        """Fit."""
        found = perception.fit_object(
            self.cloud,
            self.contacts,
            shape=self.shape,
            fillet=self.fillet,
            fillet_sd=self.fillet_sd,
            relief=self.relief,
        )
        self.solid = found
        # a wire has no surface beside it that the map could add
        whole = (
            self.cloud if self.relief is None or found.kind.startswith("wire") else told_points(self.cloud, self.relief)
        )
        # nor has a flat top any beyond its sides, along which the membrane is as close
        beyond = (whole.seen == 0) & (outside(found, whole.points[:, :2]) > whole.cell)
        self.filled_cloud = whole.part(~(beyond | no_wire_there(found, whole.points[:, :2], self.fillet)))
        return Status.SUCCESS
