"""Shapes that are pressed into the membrane: consistent in themselves, or refused."""

from stretch_bt.hardcases.domains.indenters import bodies, height_fields, inputs, shapes, whole

__all__ = ["CASES"]

CASES = (*shapes.CASES, *height_fields.CASES, *bodies.CASES, *inputs.CASES, *whole.CASES)
