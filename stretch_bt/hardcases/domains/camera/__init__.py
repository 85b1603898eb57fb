"""The simulated depth camera: its images, and the effects on them."""

from stretch_bt.hardcases.domains.camera import frames, noise, seen

__all__ = ["CASES"]

CASES = (*seen.CASES, *noise.CASES, *frames.CASES)
