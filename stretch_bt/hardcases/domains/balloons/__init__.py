"""Filled balloons and the caps that they stand out of their cups as."""

from stretch_bt.hardcases.domains.balloons import caps, objects, responses

__all__ = ["CASES"]

CASES = (*caps.CASES, *responses.CASES, *objects.CASES)
