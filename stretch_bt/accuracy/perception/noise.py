"""The errors that a depth camera adds to the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, SheetView
from stretch_bt.frames import DepthFrame
from stretch_bt.perception import average_frames

__all__ = ["CLEAN", "CORRELATED", "WHITE_03", "WHITE_05", "WHITE_10", "Noise", "frames", "observe"]

Image = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise of a depth image: standard deviations in m, lengths in pixels.

    `correlated` is smoothed by a Gaussian of `kernel` and rescaled to its standard deviation; from frame to frame it keeps
    a share `memory`, as an autoregressive process of first order. `dropouts` and `flying` are shares of the pixels: those
    without a value, and those somewhere up to 20 mm nearer or farther. `count` frames are averaged.
    """

    white: float = 0.0
    correlated: float = 0.0
    kernel: float = 3.0
    memory: float = 0.6
    quantum: float = 0.125e-3
    dropouts: float = 0.01
    flying: float = 0.0
    count: int = 1


CLEAN = Noise(quantum=4e-6, dropouts=0.0)
WHITE_03, WHITE_05, WHITE_10 = Noise(white=0.3e-3), Noise(white=0.5e-3), Noise(white=1e-3)
CORRELATED = Noise(correlated=1e-3, count=8)


def observe(view: SheetView, noise: Noise, seed: int) -> DepthFrame:
    """Return one frame of a press, the mean of `noise.count`; the same seed gives the same frame."""
    return average_frames(frames(view, noise, seed))


def frames(view: SheetView, noise: Noise, seed: int) -> list[DepthFrame]:
    """Return `noise.count` successive frames of a press at rest."""
    rng = np.random.default_rng(seed)
    smooth = _smooth(noise, view.depth.shape, rng)
    found = []
    for number in range(noise.count):
        if number:
            fresh = _smooth(noise, view.depth.shape, rng)
            smooth = noise.memory * smooth + np.sqrt(1.0 - noise.memory**2) * fresh
        raw = _counts(view.depth + smooth, view.depth > 0, noise, rng)
        found.append(
            DepthFrame(
                raw,
                noise.quantum,
                CAMERA,
                number / 30.0,
                number,
                PLANE_DISTANCE,
                hand_height=0.0,
                stretch=view.press.stretch,
            )
        )
    return found


def _smooth(noise: Noise, shape: tuple[int, ...], rng: np.random.Generator) -> Image:
    """Return correlated noise (h, w), m, one frame of it."""
    from scipy.ndimage import gaussian_filter

    if noise.correlated == 0.0:
        return np.zeros(shape)
    margin = int(4 * noise.kernel)
    wide = rng.standard_normal((shape[0] + 2 * margin, shape[1] + 2 * margin))
    blurred = gaussian_filter(wide, noise.kernel)[margin:-margin, margin:-margin]
    return np.asarray(noise.correlated * 2.0 * np.sqrt(np.pi) * noise.kernel * blurred)


def _counts(
    depth: Image, visible: npt.NDArray[np.bool_], noise: Noise, rng: np.random.Generator
) -> npt.NDArray[np.uint16]:
    measured = depth + noise.white * rng.standard_normal(depth.shape)
    if noise.flying > 0.0:
        flies = rng.random(depth.shape) < noise.flying
        measured[flies] += rng.uniform(-20e-3, 20e-3, int(flies.sum()))
    kept = visible & (rng.random(depth.shape) >= noise.dropouts)
    counts = np.clip(np.rint(measured / noise.quantum), 0, 65535)  # counts of 16 bits end here
    return np.where(kept & (counts < 65535), counts, 0).astype(np.uint16)
