"""Filled balloons, and the caps of them that stand out of their cups."""

from stretch_bt.hardcases.domains.balloons import caps, objects, responses

__all__ = ["CASES"]

CASES = (*caps.CASES, *responses.CASES, *objects.CASES)
