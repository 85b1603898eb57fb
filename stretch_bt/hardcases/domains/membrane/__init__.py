"""Presses of the membrane that its solvers must answer or refuse."""

from stretch_bt.hardcases.domains.membrane import guards, inputs, paths, presses

__all__ = ["CASES"]

CASES = (*presses.CASES, *paths.CASES, *guards.CASES, *inputs.CASES)
