"""A simulated depth camera."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.driver import CameraDriver, Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.units import Frequency, Within

if TYPE_CHECKING:
    from stretch_bt.simulation.camera import DepthRenderer

__all__ = ["SimulatedCamera"]

#: what of the table is in view beside the membrane, m
_MARGIN = 0.008


class _Options(Options):
    type: Literal["DepthCamera"]
    use: Literal["simulated"]
    rate: Annotated[Frequency, Within(0.1, 1000.0, "Frequency")] = 30.0
    image: Literal["membrane", "full"] = Field(
        default="membrane", description="the part that the membrane can reach, or all"
    )


class SimulatedCamera(CameraDriver):
    """Exposes a frame each period, of the hand as it is at that moment; a frame is rendered when it is asked for."""

    Options = _Options
    simulated = True
    _latest: Reading[DepthFrame] | None = None

    @cached_property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the frames, the optical axis through the centre of the membrane."""
        from stretch_bt.simulation.camera import SR305

        if self.options.image == "full":
            return SR305
        geometry = self.bench.hand.geometry
        x = SR305.fx * (geometry.width / 2 + _MARGIN) / geometry.plane_distance
        y = SR305.fy * (geometry.gauge + self.bench.limits.stretch.max) / 2 / geometry.plane_distance
        rows = max(int(SR305.cy - y), 0), min(int(SR305.cy + y) + 1, SR305.height)
        columns = max(int(SR305.cx - x), 0), min(int(SR305.cx + x) + 1, SR305.width)
        return SR305.cropped(*rows, *columns)

    @cached_property
    def _renderer(self) -> DepthRenderer:
        from stretch_bt.simulation.camera import DepthRenderer

        geometry = self.bench.hand.geometry
        return DepthRenderer(self.intrinsics, geometry.plane_distance, geometry.gauge, geometry.width)

    def frame(self) -> Reading[DepthFrame]:
        """Return the latest frame."""
        number = int(self.bench.now() * self.options.rate + 1e-6)
        if self._latest is None or self._latest.sequence != number:
            self._latest = self._expose(number)
        return self._latest

    def _expose(self, number: int) -> Reading[DepthFrame]:
        from stretch_bt.simulation.camera import add_noise

        twin, time = self.bench.twin, number / self.options.rate
        told, true = twin.hand.at(time)
        stretch = twin.stretch(time)
        contact = twin.world.contact(true, stretch)
        depth = self._renderer.render(twin.world.surface(contact), contact.axis, stretch, true.height)
        noise = twin.scene.camera
        frame = DepthFrame(
            raw=add_noise(depth, noise, twin.random(self.name, number)),
            unit=noise.quantisation,
            intrinsics=self.intrinsics,
            time=time,
            sequence=number,
            plane_distance=self.bench.hand.geometry.plane_distance,
            hand_height=told.height,
            stretch=stretch,
            pose=told,
        )
        return Reading(frame, time, time, number)
