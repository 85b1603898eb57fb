"""Membrane and object in series: any ratio of stiffness, kinks, falling forces, jumps, and laws that are rough or no numbers."""

from stretch_bt.hardcases.domains.coupling import counts, laws, series

__all__ = ["CASES"]

CASES = (*series.CASES, *laws.CASES, *counts.CASES)
