"""Taking the force at opening as zero, and refusing an arm that feels more then than nothing explains."""

from __future__ import annotations

import math

from stretch_bt.errors import NotReady
from stretch_bt.hardware.ur.arm_process import ArmProcess
from stretch_bt.hardware.ur.force_sensing import FORCE_SENSING
from stretch_bt.hardware.ur.messages import MeanWrench
from stretch_bt.hardware.ur.options import UrOptions

__all__ = ["Zeroing"]


class Zeroing:
    """The zero of one arm's force.

    Parameters
    ----------
    name
        The device, for messages.
    options
        With `tare` and `loaded`.
    process
        What feels the force.
    """

    def __init__(self, name: str, options: UrOptions, process: ArmProcess) -> None:
        self._name, self._options, self._process = name, options, process
        self._sensing = FORCE_SENSING[options.model]

    def before_program(self) -> None:
        """Look for a load that the controller would take as zero at the start of our program; raises NotReady for one."""
        if self._sensing.zeroed_at_start and not self._options.loaded:
            self._check(self._process.feel(self._sensing.zero_over), "the controller takes it as zero")

    def after_program(self) -> None:
        """Take the force as zero, where the cell file does not say otherwise; raises NotReady where it is a load."""
        if not self._options.tare:
            return
        felt = self._process.feel(self._sensing.zero_over)
        if not self._options.loaded:
            self._check(felt, "it would be taken as zero")
        self._process.zero(felt.wrench)

    def _check(self, felt: MeanWrench, then: str) -> None:
        force, most = math.hypot(*felt.wrench[:3]), self._sensing.explained(felt.count)
        if force > most:
            raise NotReady(
                self._name,
                f"it feels {force:.1f} N before a run, where bias and noise of a {self._options.model} explain {most:.1f} N, and {then}: "
                "take away what the hand touches, correct the payload, or write `loaded: true` in the cell file",
            )
