"""A simulated depth camera."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.driver import DepthCameraDriver, Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.units import Frequency
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.camera.sensor import Sensor

__all__ = ["SimulatedCamera"]


class _Options(Options):
    type: Literal["DepthCamera"]
    use: Literal["simulated"]
    rate: Annotated[Frequency, Within(0.1, 1000.0, "Frequency")] = 30.0
    image: Literal["membrane", "full"] = Field(
        default="membrane", description="part of the image: the part that the membrane can reach, or all"
    )


class SimulatedCamera(DepthCameraDriver):
    """Exposes a frame each period, of the hand as it is at that moment; a frame is rendered when it is asked for."""

    Options = _Options
    simulated = any_clock = True
    _latest: Reading[DepthFrame] | None = None

    @cached_property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the frames, the optical axis through the centre of the membrane."""
        from stretch_bt.simulation.camera.sensor import window
        from stretch_bt.simulation.camera.view import SR305

        if self.options.image == "full":
            return SR305
        geometry = self.cell.hand.geometry
        return window(geometry.width, geometry.gauge + self.cell.limits.stretch.max, geometry.plane_distance)

    @cached_property
    def _sensor(self) -> Sensor:
        from stretch_bt.simulation.camera.sensor import Sensor

        twin = self.cell.twin
        return Sensor(
            twin.world,
            self.intrinsics,
            self.cell.hand.geometry.plane_distance,
            self.options.rate,
            lambda effect, number: twin.random(f"{self.name} {effect}", number),
        )

    def frame(self) -> Reading[DepthFrame]:
        """Return the latest frame."""
        number = int(self.cell.now() * self.options.rate + 1e-6)
        if self._latest is None or self._latest.sequence != number:
            self._latest = self._expose(number)
        return self._latest

    def _expose(self, number: int) -> Reading[DepthFrame]:
        from stretch_bt.simulation.camera.counts import counts

        twin, time = self.cell.twin, number / self.options.rate
        told = twin.hand.at(time).told
        exposure = self._sensor.expose(twin.shot(time, number))
        frame = DepthFrame(
            raw=counts(exposure),
            unit=exposure.unit,
            intrinsics=self.intrinsics,
            time=time,
            sequence=number,
            plane_distance=self.cell.hand.geometry.plane_distance,
            hand_height=told.height,
            stretch=twin.stretch(time),
            pose=told,
        )
        return Reading(frame, time, time, number)
