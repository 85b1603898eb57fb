"""Is the membrane touching something: a causal test with a known rate of false alarms."""

from __future__ import annotations

import math

from stretch_bt.arguments import check_counts
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.average import check_one_hand
from stretch_bt.perception.quiet import Quiet
from stretch_bt.perception.reference import Reference, check_kernel, coarse_rise
from stretch_bt.perception.types import FloatArray
from stretch_bt.plain_numbers import is_number

__all__ = ["ContactDetector"]

FINE = 2.5  # bins that a kernel keeps
RESIDUE = 0.1  # share of the deepest press that soft material may keep for a while after release


class ContactDetector:
    """Says for each frame whether the membrane is in contact, from that frame and earlier ones only.

    The statistic is the highest Gaussian-smoothed rise above the mean of the first `reference` frames. Contact begins
    where it exceeds what frames without contact show, at `false_alarms` per frame, and ends where it falls back to that
    or, because soft material creeps back, to a tenth of the deepest press. The first `reference` + 5 frames have to be
    free of contact. A later frame counts as one without contact half a second (15 frames) after it came, and only while
    no rise has been suspected since: a press that begins slowly must not teach that rising is what noise does.

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
        if not (is_number(false_alarms) and 0.0 < false_alarms < 0.5):
            raise InvalidInput(f"false_alarms is a probability between 0 and 0.5, got {shown(false_alarms)[:80]}")
        check_counts(1, memory=memory)
        check_kernel(kernel)
        self._reference = Reference(reference)
        self._first: DepthFrame | None = None
        self._kernel = kernel
        self._false_alarms = false_alarms
        self._step = max(1, int(kernel / FINE))
        self._quiet = Quiet(memory, kernel / self._step)
        self._box = self._reference.box
        self._cover = 1.0  # share of a kernel that has depth in an ordinary frame
        self._residue = 0.0
        self._deepest = 0.0
        self.in_contact = False
        self.statistic = 0.0

    @property
    def ready(self) -> bool:
        """Whether enough frames without contact have come for a decision."""
        return self._quiet.ready

    @property
    def threshold(self) -> float:
        """The statistic, m, from which a frame counts as contact; infinite until `ready`."""
        return self._quiet.level(self._false_alarms) + self._residue if self.ready else math.inf

    def update(self, depth: FloatArray | DepthFrame) -> bool:
        """Take the next depth image (h, w), m, or frame, and return whether there is contact.

        Raises
        ------
        NoContact
            The frame has no valid pixel in common with the reference.
        InvalidInput
            The frame is of another camera, stretch or distance of the plane than the first one.
        """
        if isinstance(depth, DepthFrame):
            self._first = self._first or depth
            check_one_hand("contact detector", depth, self._first)
        if not self._reference.complete:
            self._reference.learn(depth)
            self._box = self._reference.box
            self._cover = self._reference.cover(self._kernel)
            return False
        rise, known = self._reference.rise(depth, self._box)
        mean, trusted = coarse_rise(rise, known, self._kernel, self._step, self._cover)
        self.statistic = float(mean[trusted].max())
        if self.in_contact:
            self._hold()
        elif self.statistic > self.threshold:
            self.in_contact, self._deepest = True, self.statistic
            self._quiet.forget_latest()
        elif self._residue == 0.0:
            self._quiet.learn(self.statistic, mean, trusted)
        else:  # while a residue creeps back, follow it down
            self._residue = min(self._residue, max(self.statistic - self._quiet.mean, 0.0))
        return self.in_contact

    def _hold(self) -> None:
        """Stay in contact until the press has gone but for what creeps back."""
        self._deepest = max(self._deepest, self.statistic)
        level = self.threshold - self._residue
        if self.statistic <= max(0.5 * (level + self._quiet.mean), RESIDUE * self._deepest):
            self.in_contact = False
            self._residue = max(self.statistic - self._quiet.mean, 0.0)
