"""How far the zero of measured depths is off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stretch_bt.model.calibration.measurements import Measurements

__all__ = ["DEPTH_ZERO", "DepthZero"]

#: in the provenance of a model
DEPTH_ZERO = "depth_zero"
_DIGITS = 9


@dataclass(frozen=True)
class DepthZero:
    """Offsets to add to measured depths, m: one to all of them, with its standard deviation, and one to each indenter's depths.

    `indenters` holds diameter and offset, m. An indenter that was not fitted has no offset of its own.
    """

    common: float
    common_sd: float
    indenters: tuple[tuple[float, float], ...] = ()

    def applied(self, given: Measurements) -> Measurements:
        """Return measurements with depths that count from the zero that was found, none below 0."""
        offset = np.full(len(given), self.common)
        for diameter, own in self.indenters:
            offset[given.of_diameter(diameter)] += own
        return replace(given, depth=np.where(given.depth > 0, np.maximum(given.depth + offset, 0.0), 0.0))

    def to_json(self) -> dict[str, Any]:
        """Return the entry of a model's file, m."""
        each = [{"diameter": d, "offset": round(own, _DIGITS)} for d, own in self.indenters]
        return {"common": round(self.common, _DIGITS), "common_sd": round(self.common_sd, _DIGITS), "indenters": each}

    @classmethod
    def of(cls, provenance: Mapping[str, Any]) -> DepthZero:
        """Return the offsets in the provenance of a fitted model, and 0 where the fit looks for no zero."""
        given = provenance.get(DEPTH_ZERO)
        if given is None:
            return cls(0.0, 0.0)
        each = tuple((row["diameter"], row["offset"]) for row in given["indenters"])
        return cls(given["common"], given["common_sd"], each)
