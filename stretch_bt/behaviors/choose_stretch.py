"""The stretch that gives a wanted force."""

from stretch_bt.behaviors._models import ModelBehavior, inverted, within_range
from stretch_bt.errors import NoAnswer
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length


@node
class ChooseStretch(ModelBehavior):
    """Find the stretch that gives the wanted force at a depth, or the nearest one; FAILURE when none gives it and no nearest is wanted.

    FAILURE as well where the model does not cover radius, depth or `max_stretch`.
    """

    radius: In[Length] = port(min=0.001, max=1.0, doc="radius of the sphere in contact")
    depth: In[Length] = port(min=0.0, doc="depth of the membrane")
    force: In[Force] = port(min=0.0, doc="wanted force")
    nearest: In[bool] = port(
        False, doc="whether to take the end of the range that comes nearest where no stretch gives the force"
    )
    max_stretch: In[Length] = port(
        0.080,
        min=0.0,
        max=0.080,
        doc="largest stretch; with nearest, taken where none is hard enough and the model reaches it",
    )
    stretch: Out[Length]  # stretch that gives the force

    def update(self) -> Status:
        """Invert the force model."""
        try:
            self.stretch = self._inverted()
        except NoAnswer:
            if not self.nearest:
                raise
            self.stretch = Estimate(self._nearest(), 0.0)  # which is chosen, not estimated
        return Status.SUCCESS

    def _inverted(self) -> Estimate:
        model, radius, depth = self.force_model(), self.radius, self.depth
        with within_range():
            stretch = model.stretch_for(radius, depth, self.force)
            if stretch > self.max_stretch:
                mm, most = 1e3 * stretch, 1e3 * self.max_stretch
                raise NoAnswer(
                    f"{self.force:.3g} N takes a stretch of {mm:.3g} mm, above {most:.3g} mm; press deeper, or allow more"
                )
            return inverted(stretch, lambda x: model.predict(radius, x, depth))

    def _nearest(self) -> float:
        """Return the end of the allowed stretches that comes nearest, m, where the model answers."""
        model, radius, depth = self.force_model(), self.radius, self.depth
        least, most = model.range.stretch
        most = min(most, self.max_stretch)
        with within_range():
            model.range.check(stretch=most)
            if self.force <= model.predict(radius, least, depth)[0]:
                return least
            model.predict(radius, most, depth)
        return most
