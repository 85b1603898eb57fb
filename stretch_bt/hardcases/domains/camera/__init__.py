"""The simulated depth camera: what it sees, and what its effects do to that."""

from stretch_bt.hardcases.domains.camera import frames, noise, seen

__all__ = ["CASES"]

CASES = (*seen.CASES, *noise.CASES, *frames.CASES)
