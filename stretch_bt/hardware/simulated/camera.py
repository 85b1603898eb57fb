"""A simulated depth camera."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.driver import CameraDriver, Options
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.units import Frequency, Within

if TYPE_CHECKING:
    from stretch_bt.simulation.camera.renderer import DepthRenderer
    from stretch_bt.simulation.effects.base import CameraEffect, Exposure

__all__ = ["SimulatedCamera"]

Image = npt.NDArray[np.float32]

#: one count where nothing rounds to coarser ones, m
_UNIT = 1e-5

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
    _clean: tuple[Any, Image] | None = None

    @cached_property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the frames, the optical axis through the centre of the membrane."""
        from stretch_bt.simulation.camera.view import SR305

        if self.options.image == "full":
            return SR305
        geometry = self.bench.hand.geometry
        x = SR305.fx * (geometry.width / 2 + _MARGIN) / geometry.plane_distance
        y = SR305.fy * (geometry.gauge + self.bench.limits.stretch.max) / 2 / geometry.plane_distance
        rows = max(int(SR305.cy - y), 0), min(int(SR305.cy + y) + 1, SR305.height)
        columns = max(int(SR305.cx - x), 0), min(int(SR305.cx + x) + 1, SR305.width)
        return SR305.cropped(*rows, *columns)

    @cached_property
    def _effects(self) -> list[CameraEffect]:
        from stretch_bt.simulation.effects.base import CameraEffect

        return self.bench.twin.world.effects.of(CameraEffect)  # type: ignore[type-abstract]

    @cached_property
    def _renderer(self) -> DepthRenderer:
        from stretch_bt.simulation.camera.renderer import DepthRenderer
        from stretch_bt.simulation.camera.view import Offset

        lens = self.intrinsics
        for effect in self._effects:
            lens = effect.lens(lens)
        offset = Offset(**self.bench.twin.scene.hand.camera.model_dump())
        return DepthRenderer(lens, self.bench.hand.geometry.plane_distance, offset)

    def frame(self) -> Reading[DepthFrame]:
        """Return the latest frame."""
        number = int(self.bench.now() * self.options.rate + 1e-6)
        if self._latest is None or self._latest.sequence != number:
            self._latest = self._expose(number)
        return self._latest

    def _expose(self, number: int) -> Reading[DepthFrame]:
        from stretch_bt.simulation.camera.counts import counts

        twin, time = self.bench.twin, number / self.options.rate
        told = twin.hand.at(time).told
        seen = time - twin.delay("DepthCamera")
        exposure = self._seen(seen, number)
        for effect in self._effects:
            with twin.world.stats.timed(effect.name):
                effect.expose(exposure)
        frame = DepthFrame(
            raw=counts(exposure),
            unit=exposure.unit,
            intrinsics=self.intrinsics,
            time=time,
            sequence=number,
            plane_distance=self.bench.hand.geometry.plane_distance,
            hand_height=told.height,
            stretch=twin.stretch(time),
            pose=told,
        )
        return Reading(frame, time, time, number)

    def _seen(self, time: float, number: int) -> Exposure:
        """Return what the camera would see at a time, s, without anything added; unchanged since the last frame it is kept."""
        from stretch_bt.simulation.camera.skin import table_under
        from stretch_bt.simulation.effects.base import Exposure

        twin = self.bench.twin
        pose, stretch = twin.hand.at(time).true, twin.stretch(time)
        contact = twin.contact(time)
        if self._clean is None or self._clean[0] != (pose, stretch, contact):
            skin = twin.world.skin(contact, stretch)
            with twin.world.stats.timed("render"):
                self._clean = ((pose, stretch, contact), self._renderer.render(skin, table_under(pose)))
        return Exposure(
            self._clean[1].copy(),
            self.intrinsics,
            number / self.options.rate,
            number,
            self.options.rate,
            lambda name, k: twin.random(f"{self.name} {name}", k),
            _UNIT,
        )
