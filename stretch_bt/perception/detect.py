"""Is the membrane touching something: a causal test with a known rate of false alarms."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.reference import Reference, smoothed_rise
from stretch_bt.perception.types import FloatArray

__all__ = ["ContactDetector"]

LEAST = 5  # frames without contact from which a threshold can be had
RESIDUE = 0.1  # share of the deepest press that soft material may keep for a while after release


class ContactDetector:
    """Says for each frame whether the membrane is in contact, from that frame and earlier ones only.

    The statistic is the highest Gaussian-smoothed rise above the mean of the first `reference` frames. Contact begins
    where it exceeds what frames without contact show, at `false_alarms` per frame, and ends where it falls back to that
    or, because soft material creeps back, to a tenth of the deepest press. The first `reference` + 5 frames have to be
    free of contact.

    Parameters
    ----------
    reference : int
        Frames that form the reference.
    kernel : float, pixels
        Standard deviation of the Gaussian.
    false_alarms : float
        Probability that one frame without contact is called one.
    memory : int
        How many of the latest frames without contact set the threshold.
    """

    def __init__(
        self, *, reference: int = 5, kernel: float = 10.0, false_alarms: float = 1e-3, memory: int = 60
    ) -> None:
        if not 0.0 < false_alarms < 0.5:
            raise InvalidInput(f"false_alarms is a probability between 0 and 0.5, got {false_alarms}")
        if not kernel > 0:
            raise InvalidInput(f"kernel is a positive number of pixels, got {kernel}")
        if memory < LEAST:
            raise InvalidInput(f"memory is at least {LEAST} frames, got {memory}")
        self._reference = Reference(reference)
        self._kernel = kernel
        self._false_alarms = false_alarms
        self._quiet: deque[float] = deque(maxlen=memory)
        self._residue = 0.0
        self._deepest = 0.0
        self.in_contact = False
        self.statistic = 0.0

    @property
    def ready(self) -> bool:
        """Whether enough frames without contact have come for a decision."""
        return len(self._quiet) >= LEAST

    @property
    def threshold(self) -> float:
        """The statistic, m, from which a frame counts as contact; infinite until `ready`."""
        if not self.ready:
            return math.inf
        quiet = np.array(self._quiet)
        return float(quiet.mean() + _quantile(self._false_alarms, len(quiet)) * quiet.std(ddof=1)) + self._residue

    def update(self, depth: FloatArray | DepthFrame) -> bool:
        """Take the next depth image (h, w), m, or frame, and return whether there is contact.

        Raises
        ------
        NoContact
            The frame has no valid pixel in common with the reference.
        """
        if not self._reference.complete:
            self._reference.learn(depth)
            return False
        mean, trusted = smoothed_rise(*self._reference.rise(depth), self._kernel)
        self.statistic = float(mean[trusted].max())
        if self.in_contact:
            self._hold()
        elif self.statistic > self.threshold:
            self.in_contact, self._deepest = True, self.statistic
        else:
            self._rest()
        return self.in_contact

    def _hold(self) -> None:
        """Stay in contact until the press has gone but for what creeps back."""
        self._deepest = max(self._deepest, self.statistic)
        level = self.threshold - self._residue
        if self.statistic <= max(0.5 * (level + float(np.mean(self._quiet))), RESIDUE * self._deepest):
            self.in_contact = False
            self._residue = max(self.statistic - float(np.mean(self._quiet)), 0.0)

    def _rest(self) -> None:
        """Learn from a frame without contact; while a residue creeps back, follow it down instead."""
        if self._residue == 0.0:
            self._quiet.append(self.statistic)
        else:
            self._residue = min(self._residue, max(self.statistic - float(np.mean(self._quiet)), 0.0))


def _quantile(probability: float, count: int) -> float:
    """Return how many standard deviations above the mean of `count` values a further one exceeds with a probability.

    Maxima of many places follow Gumbel's law; the uncertainty of a mean and deviation from few values is Student's.
    """
    from scipy.special import ndtri, stdtrit

    gumbel = -(math.log(-math.log1p(-probability)) + np.euler_gamma) * math.sqrt(6.0) / math.pi
    widened = float(stdtrit(count - 1, 1.0 - probability)) / float(ndtri(1.0 - probability))
    return gumbel * widened * math.sqrt(1.0 + 1.0 / count)
