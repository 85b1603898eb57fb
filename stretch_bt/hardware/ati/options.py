"""Options of a sensor that streams by RDT."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from stretch_bt.hardware.address import Address
from stretch_bt.hardware.ati.rdt import PORT
from stretch_bt.hardware.driver import Mistake, Options
from stretch_bt.units import Angle, Time
from stretch_bt.within import Within

__all__ = ["AtiOptions"]

_Counts = Annotated[float, Within(1.0, 1e9)]
_Turn = Annotated[Angle, Within(-math.pi, math.pi, "Angle")]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class _Calibration(_Model):
    """Counts of a unit, as the sensor's page `netftapi2.xml` has them (cfgcpf and cfgcpt)."""

    counts_per_newton: _Counts
    counts_per_newton_metre: _Counts
    source: str = Field(min_length=1, description="which sensor, read from where, when")


class _Rotation(_Model):
    """Rotation vector from the sensor's axes to the world's."""

    x: _Turn = 0.0
    y: _Turn = 0.0
    z: _Turn = 0.0


class AtiOptions(Options):
    """Where the sensor is, how it is calibrated and mounted."""

    type: Literal["ForceSensor"]
    use: Literal["ati"]
    host: Address = Field(description="address of the sensor")
    port: Annotated[int, Within(1, 65535)] = PORT
    calibration: _Calibration
    mount: Literal["table", "hand"] = Field(
        default="table",
        description="place of the sensor: under the object, so that it feels what the hand does, or between arm and hand",
    )
    rotation: _Rotation = _Rotation()
    silence: Annotated[Time, Within(0.02, 5.0, "Time")] = Field(
        default=0.1, description="time without a measurement after which the stream is asked for again"
    )
    lost_after: Annotated[Time, Within(0.05, 10.0, "Time")] = Field(
        default=0.5, description="time without a new measurement after which the sensor counts as lost"
    )
    noisy: bool = Field(
        default=True,
        description="whether no two measurements are alike, so that one that stands is found; false where there is no noise",
    )
    zero_over: Annotated[Time, Within(0.0, 5.0, "Time")] = Field(
        default=0.1, description="duration of the latest measurements that `zero` averages"
    )

    def mistakes(self, root: Path) -> Iterator[Mistake]:
        """Yield a sensor that is lost before its stream is asked for again."""
        if self.silence >= self.lost_after:
            told = f"the stream is asked for again after {1e3 * self.silence:g} ms, and lost after {1e3 * self.lost_after:g} ms"
            yield "silence", told, "write a `silence` of at most half of `lost_after`"
