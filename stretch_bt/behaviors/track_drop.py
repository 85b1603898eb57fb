"""Telling how far the object has given way, from all presses together."""

import math

from stretch_bt import model as mechanics
from stretch_bt.behaviors._membrane import Mounting, told_by_membrane
from stretch_bt.behaviors._models import ModelBehavior, within_range
from stretch_bt.behaviors._readings import Fitted, Reading, of_one_kind, of_press, reading_sd, readings_of, tell_again
from stretch_bt.perception.pattern import Pattern
from stretch_bt.perception.pressed.height import FORM_OFF
from stretch_bt.tree.ports import In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length

CREPT = 3.0  # standard deviations by which older readings of a press must differ from newer ones to count as past
LEAST_SD = 1e-6  # m
LEAST_RADIUS_SD = 1e-4  # m


@node
class TrackDrop(ModelBehavior):
    """Tell how far the object's top has dropped at the present press, from this reading and those before it.

    Readings are those that `approach` took at the first touch and one from each time that this node runs. The object is in series
    with the membrane, whose force the model gives; the curve of force over drop through all readings gives the height at no force, which no
    reading shows, and evens out the noise of single ones. The heights of the first touches are told again with the radius, and by the whole
    membrane where `track_height` told the latest height by it, since heights of two kinds do not go together. Without readings by
    `approach` its `contact_height` counts instead.

    `crept` compares the newer half of this press' readings with the older: an object that still gives way makes it
    negative. Where it is so by three standard deviations, the older half no longer counts.
    """

    radius: In[Length] = port(min=0.001, max=1.0, doc="of the sphere in contact")
    stretch: In[Length] = port(min=0.0, max=0.080, doc="past the rest length")
    depth: In[Length] = port(
        doc="of the membrane at this press: travel past first contact less what the object gave way"
    )
    height: In[Length] = port(doc="of the top at this press, as measured")
    height_sd: In[Length] = port(1e-4, min=0.0, doc="standard deviation of height")
    frames: In[int] = port(8, min=1, max=256, doc="averaged for height")
    frame_noise: In[Length] = port(
        0.0, min=0.0, max=0.01, doc="by which a height is off at least in one frame, whatever height_sd says"
    )
    fresh: In[bool] = port(
        False, doc="forget this press' readings before this one: the object was left alone since then"
    )
    radius_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of radius")
    contact_height: In[Length] = port(doc="of the undeformed top, as `approach` found it")
    contact_height_sd: In[Length] = port(0.0, min=0.0, doc="standard deviation of contact_height")
    power: In[float] = port(
        mechanics.POWER.value, min=0.5, max=4.0, doc="of its drop by which the object's force grows, before any reading"
    )
    power_sd: In[float] = port(mechanics.POWER.sd, min=1e-3, max=2.0, doc="standard deviation of power")
    stiffening: In[float] = port(
        mechanics.STIFFENING.value, min=-1.0, max=2.0, doc="growth of power per millimetre of drop, before any reading"
    )
    stiffening_sd: In[float] = port(mechanics.STIFFENING.sd, min=1e-4, max=2.0, doc="standard deviation of stiffening")
    robot_sd: In[Length] = port(
        mechanics.ROBOT, min=0.0, max=0.001, doc="by which the hand stands off where it is sent"
    )
    top: Out[Length] = port(truth="contact_height")  # height of the undeformed top
    settled: Out[Length] = port(truth="height")  # height of the top at this press, on the curve
    drop: Out[Length] = port(truth="deflection")  # how far the top has given way, on the curve
    force: Out[Force] = port(truth="force")  # on the object at this press, by the model
    together: Out[float]  # correlation of the errors of force and drop
    crept: Out[Length]  # by how much the newer readings of this press stand above the older; 0 while there is one

    def update(self) -> Status:
        """Add this reading and fit all."""
        readings = readings_of(self.context)
        sd = max(reading_sd(self.height_sd, self.frames, self.frame_noise), LEAST_SD)
        reading = Reading(self.stretch, self.depth, self.height, sd, frames=self.frames)
        if self.fresh:
            for unsettled in of_press(readings, reading):
                readings.remove(unsettled)
        readings.append(reading)
        curvature = Estimate(1 / self.radius, max(self.radius_sd, LEAST_RADIUS_SD) / self.radius**2)
        tell_again(self.context, curvature, by_membrane=told_by_membrane(self.context))
        fit = self._fit(readings)
        self.crept, older = _crept(of_press(readings, readings[-1]), math.sqrt(max(fit.chi2, 1.0)))
        if older:
            for reading in older:
                readings.remove(reading)
            fit = self._fit(readings)
        self.context.memory[Fitted] = Fitted(fit, readings[-1])
        self.top, self.settled, self.drop, self.force = fit.top, fit.height, fit.drop, fit.force
        self.together = fit.together
        return Status.SUCCESS

    def _fit(self, readings: list[Reading]) -> mechanics.Series:
        """Fit; a touch whose readings are not known counts by its height alone."""
        touched = any(reading.touch is not None for reading in readings)
        top = None if touched else Estimate(self.contact_height, max(self.contact_height_sd, LEAST_SD))
        pattern = self.context.memory.get(Pattern)
        with within_range():
            return mechanics.fit_series(
                self.force_model(),
                Estimate(self.radius, self.radius_sd),
                of_one_kind(readings),
                top=top,
                power=Estimate(self.power, self.power_sd),
                stiffening=Estimate(self.stiffening, self.stiffening_sd),
                robot_sd=self.robot_sd,
                common_sd=math.hypot(
                    pattern.hang_sd if pattern is not None else 0.0,
                    FORM_OFF if Mounting in self.context.memory else 0.0,
                ),
            )


def _crept(press: list[Reading], noise: float) -> tuple[Estimate, list[Reading]]:
    """Return by how much the newer half of a press' readings stands above the older, and what of the older no longer counts."""
    if len(press) < 2:
        return Estimate(0.0, 0.0), []
    halves = press[: len(press) // 2], press[len(press) // 2 :]
    means = [sum(r.height for r in half) / len(half) for half in halves]
    sds = [math.hypot(*(r.sd for r in half)) / len(half) for half in halves]
    crept = Estimate(means[1] - means[0], noise * math.hypot(*sds))
    return crept, halves[0] if abs(crept.value) > CREPT * crept.sd else []
