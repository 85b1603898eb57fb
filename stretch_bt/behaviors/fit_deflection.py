"""Fitting the force law of an object to the heights of its top at all presses."""

import math
from collections.abc import Sequence
from operator import attrgetter

from stretch_bt import model as mechanics
from stretch_bt.behaviors._membrane import is_mounted
from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.behaviors._readings import Reading, infer_again, of_one_kind, without_crept
from stretch_bt.behaviors.records import Felt, Mounting, TopReadings, Touch
from stretch_bt.errors import IllConditioned
from stretch_bt.model.palpation.reloading import of_first_loading
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.pressed.height import FORM_OFF
from stretch_bt.perception.types import Sphere
from stretch_bt.tree.ports import In, InOut, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Length

LEAST_SD = 1e-6  # m
LEAST_RADIUS_SD = 1e-4  # m
LEAST_RADIUS, MOST_RADIUS = 0.001, 1.0  # m


@node
class FitDeflection(ModelBehavior):
    """Fit an object's force over deflection to all readings of its top, and find its deflection at the latest press.

    The object is in series with the membrane, whose force the model gives. The curve through all readings gives the height of the top at no
    force, which no reading shows, and evens out the noise of single ones. The heights of first touches are inferred again with the radius
    of the sphere, and by the whole membrane where that gave the latest height, since heights of two kinds do not go together. Without
    first touches the height of `touch` counts instead.

    Where the newer half of the latest press' readings differs from the older by three deviations, the object creeps, and the older half no
    longer counts. Readings at less force than an earlier press do not count either where they stand three deviations below the curve of
    the others: the object shows hysteresis. FAILURE where the latest reading is one of them.
    """

    touch: In[Touch]  # first contact
    sphere: In[Sphere]  # sphere in contact
    top_readings: InOut[TopReadings]  # readings since first contact; the latest is of the present press
    pattern: In[Pattern | None] = None  # static error of the camera, as far as it was learned
    mounting: In[Mounting | None] = None  # mounting of the membrane, as far as it is known
    power: In[float] = port(
        mechanics.POWER.value, min=0.5, max=4.0, doc="Exponent p of the object's force law F ~ deflection^p, expected."
    )
    power_sd: In[float] = port(mechanics.POWER.sd, min=1e-3, max=2.0, doc="standard deviation of power")
    stiffening: In[float] = port(
        mechanics.STIFFENING.value, min=-1.0, max=2.0, doc="Growth of p with each millimetre of deflection, expected."
    )
    stiffening_sd: In[float] = port(mechanics.STIFFENING.sd, min=1e-4, max=2.0, doc="standard deviation of stiffening")
    robot_sd: In[Length] = port(
        mechanics.ROBOT, min=0.0, max=0.001, doc="Standard deviation of the hand's positioning error."
    )
    felt: Out[Felt] = port(
        truth={"top": "contact_height", "height": "height", "deflection": "deflection", "force": "force"},
        doc="the object's force law, and the latest press on it",
    )

    def update(self) -> Status:
        """Fit all."""
        if not self.top_readings.count:
            raise IllConditioned("no height of the top was read yet; run 'add_reading' first")
        readings = self._inferred(self.top_readings.readings)
        latest = readings[-1]
        readings, series, creep = without_crept(readings, self._fit)
        with within_range():
            given = (self._fit, self.force_model(), self.sphere.radius, self.robot_sd, attrgetter("by_membrane"))
            readings, series = of_first_loading(readings, series, *given)
        self.top_readings = TopReadings(tuple(readings))
        self.felt = Felt.of(series, creep, latest)
        return Status.SUCCESS

    def _inferred(self, readings: Sequence[Reading]) -> list[Reading]:
        """Return the readings with the heights of first touches inferred with the radius."""
        radius, sd = self.sphere.radius, self.sphere.radius_sd
        if not LEAST_RADIUS <= radius <= MOST_RADIUS:
            raise IllConditioned(f"a sphere of radius {radius * 1e3:.4g} mm is no object that the hand can feel")
        curvature = Estimate(1 / radius, max(sd, LEAST_RADIUS_SD) / radius**2)
        hand, by_membrane = self.context.hand.geometry, readings[-1].by_membrane
        return infer_again(readings, curvature, hand, self.mounting, by_membrane=by_membrane)

    def _fit(self, readings: list[Reading]) -> mechanics.Series:
        """Fit; first contact counts by its height alone where no first touch is among the readings."""
        touch, touched = self.touch, any(reading.touch is not None for reading in readings)
        with within_range():
            return mechanics.fit_series(
                self.force_model(),
                Estimate(self.sphere.radius, self.sphere.radius_sd),
                of_one_kind(readings),
                top=None if touched else Estimate(touch.height, max(touch.height_sd, LEAST_SD)),
                power=Estimate(self.power, self.power_sd),
                stiffening=Estimate(self.stiffening, self.stiffening_sd),
                robot_sd=self.robot_sd,
                common_sd=math.hypot(
                    self.pattern.hang_sd if self.pattern is not None else 0.0,
                    FORM_OFF if is_mounted(self.mounting) else 0.0,
                ),
            )
