"""Presses of the membrane that its solvers must answer or refuse."""

from stretch_bt.hardcases.domains.membrane import guards, inputs, paths, presses, solving, surfaces

__all__ = ["CASES"]

CASES = (*presses.CASES, *surfaces.CASES, *paths.CASES, *guards.CASES, *solving.CASES, *inputs.CASES)
