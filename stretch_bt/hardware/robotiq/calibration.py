"""Which count of the gripper is which opening: measured on the gripper, kept in the cell file with where it is from."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.quantity_text import format_apart, format_quantity
from stretch_bt.units import KINDS, Length
from stretch_bt.within import Within

__all__ = ["GripperCalibration"]

_MM = KINDS["Length"]


class _Point(BaseModel):
    """A count, and the opening that was measured there."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    count: Annotated[int, Within(0, 255)]
    opening: Annotated[Length, Within(0.0, 0.5, "Length")]


class GripperCalibration(BaseModel):
    """Openings measured at counts; in between they are on straight lines."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    points: list[_Point] = Field(
        min_length=2, description="`{count: 3, opening: 140 mm}`, at least two, measured with callipers"
    )
    source: str = Field(min_length=1, description="who measured it, on which gripper, when")

    @model_validator(mode="after")
    def _falling(self) -> GripperCalibration:
        ordered = sorted(self.points, key=lambda p: p.count)
        for one, other in pairwise(ordered):
            if not (one.count < other.count and one.opening > other.opening):
                raise InvalidInput(
                    f"the opening must fall as the count grows, but count {one.count} is {format_quantity(one.opening, _MM)} "
                    f"and count {other.count} is {format_quantity(other.opening, _MM)}; measure these points again"
                )
        return self

    @property
    def span(self) -> tuple[float, float]:
        """The least and the greatest opening that was measured, m."""
        openings = [p.opening for p in self.points]
        return min(openings), max(openings)

    def opening(self, count: float) -> float:
        """Return the opening at a count, m; beyond the measured points the outermost lines go on."""
        counts, openings = self._table()
        i = min(max(bisect_right(counts, count) - 1, 0), len(counts) - 2)
        part = (count - counts[i]) / (counts[i + 1] - counts[i])
        return openings[i] + part * (openings[i + 1] - openings[i])

    def count(self, opening: float) -> int:
        """Return the count that is nearest to an opening, m; raises InvalidInput outside what was measured."""
        low, high = self.span
        if not low - 1e-9 <= opening <= high + 1e-9:
            asked, least, most = format_apart(_MM, opening, low, high)
            remedy = "stay within, or measure more `points` of its `calibration` in the cell file"
            raise InvalidInput(f"opening {asked} was not calibrated, but {least} to {most}; {remedy}")
        return self.nearest(opening)

    def nearest(self, opening: float) -> int:
        """Return the count that is nearest to an opening, m, wherever it is."""
        counts, openings = self._table()
        i = next((k for k in range(len(counts) - 2) if openings[k + 1] <= opening), len(counts) - 2)
        part = (opening - openings[i]) / (openings[i + 1] - openings[i])
        return min(max(round(counts[i] + part * (counts[i + 1] - counts[i])), 0), 255)

    def _table(self) -> tuple[list[int], list[float]]:
        ordered = sorted(self.points, key=lambda p: p.count)
        return [p.count for p in ordered], [p.opening for p in ordered]
