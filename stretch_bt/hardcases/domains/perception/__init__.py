"""Images, contacts, heights, outlines, clouds and sizes that perception must answer or refuse."""

from stretch_bt.hardcases.domains.perception import (
    cameras,
    clouds,
    contacts,
    frames,
    given,
    heights,
    inputs,
    limits,
    outlines,
    rectangle,
    relief,
    size,
    solids,
)

__all__ = ["CASES"]

_PARTS = (frames, cameras, contacts, heights, inputs, outlines, size, rectangle, clouds, relief, solids, limits, given)

CASES = tuple(hard for part in _PARTS for hard in part.CASES)
