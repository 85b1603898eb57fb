"""Dough that is rolled, pressed and lifted."""

from stretch_bt.hardcases.domains.dough import discs, foretold, lumps, resistances, runs

__all__ = ["CASES"]

CASES = (*lumps.CASES, *discs.CASES, *resistances.CASES, *runs.CASES, *foretold.CASES)
