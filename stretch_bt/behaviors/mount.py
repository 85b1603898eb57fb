"""Having an indenter mounted."""

from contextlib import suppress

from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import UnsetKey
from stretch_bt.hardware.indenters import check_indenter
from stretch_bt.hardware.interfaces import Motion, Operator
from stretch_bt.tree.ports import In, InOut, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Angle, Length


@node
class Mount(MotionBehavior):
    """Ask the operator to mount an indenter in place of the object under the hand, and wait until it is done.

    It unsets `touch`, as the height of first contact is then no longer known: run `approach` next. Raise the hand well clear before.
    """

    operator: Uses[Operator]
    geometry: In[str]  # shape of the indenter: sphere, cylinder or cone
    diameter: In[Length] = port(0.0, min=0.0, doc="diameter of a sphere or cylinder")
    angle: In[Angle] = port(0.0, min=0.0, doc="angle of a cone between its surface and the membrane plane")
    touch: InOut[Touch | None]  # first contact, which is unset

    def prepare(self) -> None:
        """Refuse an indenter that no operator can mount, where it is known already."""
        with suppress(UnsetKey):
            check_indenter(self.geometry, self._size())

    def start(self) -> Motion:
        """Ask."""
        self.touch = self.context.hand.contact_height = None
        return self.operator.mount(self.geometry, self._size(), owner=self.path)

    def _size(self) -> float:
        return self.angle if self.geometry == "cone" else self.diameter
