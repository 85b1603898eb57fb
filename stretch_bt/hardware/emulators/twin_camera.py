"""A camera over a twin that is solved elsewhere: pictures come from there, noise and counts are made here."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.emulators.pictures import Picture, Pictures
from stretch_bt.hardware.emulators.setting import Setting
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.limits import Limits
from stretch_bt.simulation.advisor.advise import switch_on
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.sensor import exposed, window
from stretch_bt.simulation.effects.base import CameraEffect
from stretch_bt.simulation.effects.white_noise import WhiteNoise
from stretch_bt.simulation.noise_source import noise_source
from stretch_bt.simulation.scene import Scene, load_scene

__all__ = ["NAME", "TwinCamera", "lens"]

#: name of the camera, in the names of its sources of noise
NAME = "camera"
#: longest time from the exposure of a frame until it goes out, periods: a solution that is not ready by then is not waited for
_WAITS = 2.0


def lens(geometry: HandGeometry) -> Intrinsics:
    """Return the intrinsics of the part of the image that shows the membrane at any stretch."""
    return window(geometry.width, geometry.gauge + Limits().stretch.max, geometry.plane_distance)


class TwinCamera:
    """Exposes frames by their numbers; one whose picture is not solved in time shows the latest that is.

    Parameters
    ----------
    setting
        Setting of the scene.
    geometry
        The hand.
    pictures
        Descriptor of the memory in which the pictures are.
    rate
        Frame rate, Hz.
    seen
        Waits for the picture of a frame, and returns the numbers of the latest frame that has one, and of that picture.
    """

    def __init__(
        self,
        setting: Setting,
        geometry: HandGeometry,
        pictures: int,
        rate: int,
        seen: Callable[[int, float], tuple[int, int]],
    ) -> None:
        scene = load_scene(setting.scene)
        self._seed = setting.seed if scene.seed is None else scene.seed
        self._setting, self._geometry, self._rate, self._seen = setting, geometry, rate, seen
        self.intrinsics = lens(geometry)
        self._pictures = Pictures(pictures, (self.intrinsics.height, self.intrinsics.width))
        self._effects = _effects(scene)
        self._kept: tuple[int, Picture] | None = None
        #: frames whose picture was not solved in time
        self.late = 0

    def frame(self, number: int) -> DepthFrame | None:
        """Return the frame of a number, which is exposed `number / rate` s after the begin; None before there is a picture."""
        exposed_at = number / self._rate
        seen, picture = self._seen(number, exposed_at + _WAITS / self._rate)
        if seen < 0:
            return None
        self.late += seen < number
        exposure = exposed(self._picture(picture), self.intrinsics, self._rate, number, self._effects, self._random)
        return DepthFrame(
            raw=counts(exposure),
            unit=exposure.unit,
            intrinsics=self.intrinsics,
            time=exposed_at,
            sequence=number,
            plane_distance=self._geometry.plane_distance,
        )

    def _picture(self, number: int) -> Picture:
        if self._kept is None or self._kept[0] != number:
            self._kept = number, self._pictures.get(number)
        return self._kept[1]

    def _random(self, effect: str, number: int) -> np.random.Generator:
        return noise_source(self._seed, f"{NAME} {effect}", number)


def _effects(scene: Scene) -> list[CameraEffect]:
    """Return the camera's effects that are on; white noise is among them, because a camera without any is one whose image stands."""
    on = switch_on(scene)
    found = on.of(CameraEffect)  # type: ignore[type-abstract]
    if "white_noise" in on or "correlated_noise" in on:
        return found
    return [*found, WhiteNoise(WhiteNoise.Parameters())]
