"""A depth camera over a world: its view, and its effects on that view."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics, Pose
from stretch_bt.simulation.camera.renderer import DepthRenderer
from stretch_bt.simulation.camera.skin import Skin, table_under
from stretch_bt.simulation.camera.view import SR305, Offset
from stretch_bt.simulation.effects.base import CameraEffect, Exposure
from stretch_bt.simulation.stats import Stats
from stretch_bt.simulation.world import Contact, World

__all__ = ["Sensor", "Shot", "exposed", "window"]

Image = npt.NDArray[np.float32]

_UNIT = 1e-5  # one count, m, where nothing rounds to coarser ones
_MARGIN = 0.008  # width of the table in view beside the membrane, m


@dataclass(frozen=True, slots=True)
class Shot:
    """The time of a frame's exposure, s, its number, and how the hand and the pressed object then stand; `stretch` in m."""

    time: float
    number: int
    pose: Pose
    stretch: float
    contact: Contact


class Sensor:
    """Turns a world into exposures; `lens` is the one that the camera reports, `plane_distance`, m, the assumed distance of the
    membrane, `rate`, Hz, the frame rate, and `random(name, number)` the noise source of an effect for a frame.
    """

    def __init__(
        self,
        world: World,
        lens: Intrinsics,
        plane_distance: float,
        rate: float,
        random: Callable[[str, int], np.random.Generator],
    ) -> None:
        self.world, self.lens, self.rate, self.random = world, lens, rate, random
        self.effects = world.effects.of(CameraEffect)  # type: ignore[type-abstract]
        true = lens
        for effect in self.effects:
            true = effect.lens(true)
        self._renderer = DepthRenderer(true, plane_distance, Offset(**world.scene.hand.camera.model_dump()))
        self._clean: tuple[Skin, Pose, Image] | None = None

    def expose(self, shot: Shot) -> Exposure:
        """Return a frame on its way to counts, with every effect that is on."""
        stats = self.world.stats
        return exposed(self.clean(shot), self.lens, self.rate, shot.number, self.effects, self.random, stats)

    def clean(self, shot: Shot) -> Image:
        """Return (h, w) float32, m, the depth without any effect; it is kept while nothing changes."""
        skin = self.world.skin(shot.contact, shot.stretch)
        if self._clean is None or self._clean[0] is not skin or self._clean[1] != shot.pose:
            with self.world.stats.timed("render"):
                self._clean = (skin, shot.pose, self._renderer.render(skin, table_under(shot.pose)))
        return self._clean[2]


def exposed(
    clean: Image,
    lens: Intrinsics,
    rate: float,
    number: int,
    effects: Iterable[CameraEffect],
    random: Callable[[str, int], np.random.Generator],
    stats: Stats | None = None,
) -> Exposure:
    """Return the exposure that effects make of frame `number`'s clean (h, w) float32 depth, m; `stats` counts the effects."""
    exposure = Exposure(clean.copy(), lens, number / rate, number, rate, random, _UNIT)
    counted = stats or Stats()
    for effect in effects:
        with counted.timed(effect.name):
            effect.expose(exposure)
    return exposure


def window(width: float, length: float, plane_distance: float) -> Intrinsics:
    """Return the intrinsics of the part of the image that shows a membrane of `width` by `length`, m, and a margin beside it."""
    x = SR305.fx * (width / 2 + _MARGIN) / plane_distance
    y = SR305.fy * length / 2 / plane_distance
    rows = max(int(SR305.cy - y), 0), min(int(SR305.cy + y) + 1, SR305.height)
    columns = max(int(SR305.cx - x), 0), min(int(SR305.cx + x) + 1, SR305.width)
    return SR305.cropped(*rows, *columns)
