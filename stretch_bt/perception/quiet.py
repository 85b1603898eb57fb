"""What frames without contact show, and the level that a further one exceeds with a given probability."""

from __future__ import annotations

import math
from collections import deque
from statistics import NormalDist

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.robust import MAD_TO_SD
from stretch_bt.perception.types import MaskArray

__all__ = ["Quiet"]

Image = npt.NDArray[np.float32]

LEAST = 5  # frames without contact from which a level can be had
DELAY = 15  # frames after which one counts as without contact
SUSPECT = 0.01  # probability below which a frame may be the begin of a press, and nothing is learned
SPATIAL = 20.0  # degrees of freedom that the spread over one image is worth: it is of other places, not of other times
LEAST_RISE = 5e-5  # m above the mean; below it a sensor that warms up drifts in the time that is remembered
LONGEST = 0.95  # correlation from frame to frame, at most
OF_MAXIMUM = math.pi / math.sqrt(6.0)  # standard deviation of Gumbel's law in units of its scale


class Quiet:
    """The highest smoothed rise of frames without contact: its mean and spread.

    Few frames, which share noise with their neighbours, show little of the spread of a maximum. One image shows more:
    it holds many places of one kernel each, and the highest of N of them spreads by pi / sqrt(12 ln N) of the spread of
    one. The two are pooled, the frames with the number of independent ones among them. A maximum over images that spreads
    more than that, because some places are noisier than others, counts in full.

    Parameters
    ----------
    memory : int
        How many of the latest frames count.
    kernel : float, bins
        Standard deviation of the Gaussian that smoothed the rise, in bins of its image.
    """

    def __init__(self, memory: int, kernel: float) -> None:
        if memory < LEAST:
            raise InvalidInput(f"memory is at least {LEAST} frames, got {memory}")
        self._values: deque[float] = deque(maxlen=memory)
        self._spreads: deque[float] = deque(maxlen=memory)
        self._waiting: deque[tuple[float, float]] = deque()
        self._kernel = kernel
        self._latest: deque[Image] = deque(maxlen=2)
        self._steps = np.zeros(2)  # mean squared change of a place over one and over two frames

    @property
    def ready(self) -> bool:
        """Whether enough frames have come for a level."""
        return len(self._values) >= LEAST

    @property
    def mean(self) -> float:
        """Mean of the statistic, m."""
        return float(np.mean(self._values))

    def learn(self, statistic: float, rise: Image, trusted: MaskArray) -> None:
        """Take a frame that shows no contact: its highest smoothed rise (h, w), m, and that rise where it is trusted."""
        if self.ready and statistic > self.level(SUSPECT):
            self.forget_latest()
            return
        self._waiting.append((statistic, self._spread(rise, trusted)))
        if not self.ready or len(self._waiting) > DELAY:
            value, spread = self._waiting.popleft()
            self._values.append(value)
            self._spreads.append(spread)

    def forget_latest(self) -> None:
        """Drop the frames that are not yet known to be without contact."""
        self._waiting.clear()
        self._latest.clear()

    def level(self, probability: float) -> float:
        """Return the statistic, m, that a further frame without contact exceeds with a probability."""
        values, spatial = np.array(self._values), float(np.mean(self._spreads))
        count = max(len(values) * (1.0 - self._shared) / (1.0 + self._shared), 1.0)
        own = float(values.var(ddof=1))
        pooled = (SPATIAL * spatial**2 + (count - 1.0) * own) / (SPATIAL + count - 1.0)
        freedom = SPATIAL + count - 1.0
        above = _quantile(probability, freedom, count) * math.sqrt(max(pooled, own))
        return float(values.mean()) + max(above, LEAST_RISE)

    @property
    def _shared(self) -> float:
        """Correlation of the noise from one frame to the next, of first order: what stays the same has no part in it."""
        once, twice = self._steps
        return float(np.clip(twice / once - 1.0, 0.0, LONGEST)) if once > 0.0 and twice > 0.0 else 0.0

    def _spread(self, rise: Image, trusted: MaskArray) -> float:
        """Return the standard deviation of the maximum over an image, m, by the spread over its places."""
        step = max(1, int(self._kernel))
        coarse, seen = rise[::step, ::step], trusted[::step, ::step]
        values = coarse[seen] if seen.any() else rise[trusted]
        sd = MAD_TO_SD * float(np.median(np.abs(values - np.median(values))))
        self._follow(np.where(seen, coarse, np.float32(0)))
        places = max(np.count_nonzero(trusted) / (4.0 * math.pi * self._kernel**2), 2.0)
        return OF_MAXIMUM * sd / math.sqrt(2.0 * math.log(places))

    def _follow(self, image: Image) -> None:
        """Note how far an image differs from the last and the last but one."""
        if len(self._latest) == 2:
            changes = [float(np.mean((image - before) ** 2)) for before in reversed(self._latest)]
            self._steps += (changes - self._steps) / 20.0 if self._steps[0] > 0.0 else changes
        self._latest.append(image)


def _quantile(probability: float, freedom: float, count: float) -> float:
    """Return how many standard deviations above the mean of `count` values a further one exceeds with a probability.

    Maxima of many places follow Gumbel's law; a deviation known with some degrees of freedom, at least 20, is Student's
    (Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5).
    """
    gumbel = -(math.log(-math.log1p(-probability)) + np.euler_gamma) * math.sqrt(6.0) / math.pi
    z = NormalDist().inv_cdf(1.0 - probability)
    s = z * z
    first, second = (s + 1.0) / 4.0, ((5.0 * s + 16.0) * s + 3.0) / 96.0
    third = (((3.0 * s + 19.0) * s + 17.0) * s - 15.0) / 384.0
    widened = 1.0 + ((third / freedom + second) / freedom + first) / freedom
    return gumbel * widened * math.sqrt(1.0 + 1.0 / count)
