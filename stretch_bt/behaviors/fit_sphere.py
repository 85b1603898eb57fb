"""Fitting a sphere to a contact."""

from stretch_bt import perception
from stretch_bt.errors import IllConditioned, NoAnswer
from stretch_bt.perception.types import Contact, Sphere
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node


@node
class FitSphere(Behavior):
    """Fit a sphere to the points in contact; FAILURE when the cap is too small to determine a radius.

    With a sphere that was fitted `before` to the same object, the curvature is the mean of both, and where this contact determines no radius
    the earlier sphere stays.
    """

    kind = "perception"
    instant = True
    contact: In[Contact]  # the contact and the surface around it
    before: In[Sphere | None] = None  # an earlier fit of the same object
    sphere: Out[Sphere] = port(truth={"radius": "radius"})  # radius, centre and curvature with their deviations
    min_significance: In[float] = port(
        3.0,
        min=1.0,
        doc="least curvature to accept, in standard deviations; below 5 the fit itself refuses",
    )

    def update(self) -> Status:
        """Fit."""
        self.sphere = self._fit() if self.before is None else self._with(self.before)
        return Status.SUCCESS

    def _with(self, before: Sphere) -> Sphere:
        try:
            return perception.pooled_sphere(before, self._fit())
        except NoAnswer:
            return before

    def _fit(self) -> Sphere:
        fit = perception.fit_contact_sphere(self.contact)
        if fit.curvature < self.min_significance * fit.curvature_sd:
            raise IllConditioned(
                f"the cap carries no convex radius: its curvature is {fit.curvature:.3g} 1/m with a standard deviation of "
                f"{fit.curvature_sd:.2g}, less than {self.min_significance:g} of them"
            )
        return fit
