"""Effects of a camera on images of no pixels, near 0, of noise as large as the scene, and of nothing asked for."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics
from stretch_bt.hardcases.domains.camera.seen import CROP
from stretch_bt.hardcases.expect import Check, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.camera.averaging import frames_left
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.statistics import deviations_of
from stretch_bt.simulation.effects import CameraEffect, registry
from stretch_bt.simulation.effects.base import Exposure
from stretch_bt.simulation.effects.correlated_noise import CorrelatedNoise
from stretch_bt.simulation.effects.drift import Drift
from stretch_bt.simulation.effects.dropout import Dropout
from stretch_bt.simulation.effects.fixed_pattern import FixedPattern
from stretch_bt.simulation.effects.flying_pixels import FlyingPixels
from stretch_bt.simulation.effects.quantisation import Quantisation
from stretch_bt.simulation.effects.white_noise import WhiteNoise

Image = npt.NDArray[np.float32]

EFFECTS: dict[str, Any] = {name: effect for name, effect in registry().items() if issubclass(effect, CameraEffect)}
SHAPE = (333, 213)
FLAT: Image = np.full(SHAPE, 0.2, np.float32)
EDGED = FLAT.copy()
EDGED[:, 100:] = 0.25
#: values of parameters at which effects do nothing, and these effects
NOTHING = {"sd": "0 mm", "share": 0.0, "rate": "0 mm/s"}
IDLE = ("white_noise", "correlated_noise", "fixed_pattern", "dropout", "flying_pixels", "drift")
SHAPES = ((0, 0), (0, 30), (1, 1), (3, 40))


def _made(effect: Any, **parameters: Any) -> Any:
    return effect(effect.Parameters.model_validate(parameters))


def _exposed(
    depth: Any, effects: Iterable[Any], *, number: int = 0, seed: int = 0, lens: Intrinsics = CROP, rate: float = 30.0
) -> Exposure:
    """Send depth through effects, as the frame of this number of a run."""

    def random(name: str, k: int) -> np.random.Generator:
        return np.random.default_rng((seed, zlib.crc32(name.encode()), k + (1 << 20)))

    exposure = Exposure(np.array(depth, np.float32, order="C"), lens, number / rate, number, rate, random, 1e-5)
    for effect in effects:
        effect.expose(exposure)
    return exposure


def _seen(depth: Any, effect: Any, **options: Any) -> Image:
    return np.asarray(_exposed(depth, [effect], **options).depth)


def _gauss(kernel: float) -> list[float]:
    return [math.exp(-(k**2) / (4 * kernel**2)) for k in (1, 2, 3)]


#: effect; of 40 frames: sd, mm, correlation of pixels 1, 2, 3 apart, of frames, sd of the mean over frames, mm, share lost
ASKED: dict[str, tuple[Any, float, list[float], float, float | None, float]] = {
    "white, 0.05 mm": (_made(WhiteNoise, sd="0.05 mm"), 0.05, [0, 0, 0], 0, 0.05 / 40**0.5, 0),
    "white, 5 mm": (_made(WhiteNoise, sd="5 mm"), 5, [0, 0, 0], 0, 5 / 40**0.5, 0),
    "white, told for 100 mm": (
        _made(WhiteNoise, sd="0.1 mm", reference_depth="100 mm"),
        0.4,
        [0, 0, 0],
        0,
        0.4 / 40**0.5,
        0,
    ),
    "correlated, 3 px, memory 0.6": (_made(CorrelatedNoise), 0.3, _gauss(3), 0.6, None, 0),
    "correlated, 1.5 px, no memory": (
        _made(CorrelatedNoise, sd="1 mm", kernel=1.5, memory=0.0),
        1,
        _gauss(1.5),
        0,
        1 / 40**0.5,
        0,
    ),
    "correlated, 1 px, memory 0.9": (_made(CorrelatedNoise, kernel=1.0, memory=0.9), 0.3, _gauss(1), 0.9, None, 0),
    "correlated, 0 px": (_made(CorrelatedNoise, kernel=0.0, memory=0.3), 0.3, [0, 0, 0], 0.3, None, 0),
    "correlated, 1e-200 px": (_made(CorrelatedNoise, kernel=1e-200, memory=0.3), 0.3, [0, 0, 0], 0.3, None, 0),
    "dropout, 1 %": (_made(Dropout), 0, [0, 0, 0], 0, 0, 0.01),
    "dropout, 30 %": (_made(Dropout, share=0.3), 0, [0, 0, 0], 0, 0, 0.3),
    "dropout, all": (_made(Dropout, share=1.0), 0, [0, 0, 0], 0, 0, 1),
}


def _measured(name: str) -> Any:
    return deviations_of([_seen(FLAT, ASKED[name][0], number=n) for n in range(40)], FLAT)


def _as_asked(name: str) -> Check:
    _, sd, beside, after, fixed, lost = ASKED[name]

    def check(found: Any) -> bool:
        spread = abs(found.sd * 1e3 - sd) <= 0.03 * sd and np.abs(np.subtract(found.beside, beside)).max() < 0.02
        steady = fixed is None or abs(found.fixed * 1e3 - fixed) <= 0.05 * fixed + 1e-9
        return bool(spread and abs(found.after - after) < 0.02 and steady and abs(found.lost - lost) <= 0.03 * lost)

    return Check("deviation, correlation and loss as asked for", check)


def _counted(name: str, shape: tuple[int, int]) -> tuple[int, ...]:
    lens = CROP.cropped(0, shape[0], 0, shape[1])
    return counts(_exposed(np.full(shape, 0.2), [_made(EFFECTS[name])], lens=lens)).shape


def _near_zero(name: str) -> list[bool]:
    """Whether pixels without depth stay without, all is finite, and nothing is below 0, at 4 mm under noise of 50 mm."""
    depth = np.full(SHAPE, 0.004, np.float32)
    depth[50:100] = 0.0
    sizes = {"sd": "50 mm"} if "sd" in EFFECTS[name].Parameters.model_fields else {}
    seen = _seen(depth, _made(EFFECTS[name], **sizes), number=9000)
    return [not seen[50:100].any(), bool(np.isfinite(seen).all()), bool((seen >= 0).all())]


def _idle(name: str) -> bool:
    fields = EFFECTS[name].Parameters.model_fields
    effect = _made(EFFECTS[name], **{field: v for field, v in NOTHING.items() if field in fields})
    return np.array_equal(_seen(EDGED, effect, number=500), EDGED)


def _hardly(name: str, share: float) -> bool:
    """Whether an effect on so small a share of the pixels leaves a frame as it was."""
    return np.array_equal(_seen(EDGED, _made(EFFECTS[name], share=share), number=3), EDGED)


def _repeated(name: str) -> bool:
    """Whether a frame depends on its number and seed alone, whatever was asked before, and is another one of another seed."""
    effect = EFFECTS[name]
    parameters = effect.Parameters.model_validate({"share": 0.3} if name == "flying_pixels" else {})
    forward = [_seen(EDGED, straight, number=n, seed=3) for straight in [effect(parameters)] for n in range(12)]
    back = effect(parameters)
    same = True
    for n in (11, 4, 9, 0):
        _seen(EDGED, back, number=n + 1, seed=8)  # another run of the same effect in between
        same = same and all(
            np.array_equal(_seen(EDGED, e, number=n, seed=3), forward[n]) for e in (back, effect(parameters))
        )
    other = not np.array_equal(_seen(EDGED, effect(parameters), number=9, seed=4), forward[9])
    return same and (other or name == "drift")


def _memory() -> list[float]:
    """Return the correlation of frames 1, 2, 3 and 5 apart, less the one by a memory of 0.7."""
    effect = _made(CorrelatedNoise, memory=0.7)
    stack = np.stack([_seen(FLAT, effect, number=n) for n in range(60)]).astype(float) - 0.2
    return [float((stack[k:] * stack[:-k]).mean() / (stack**2).mean() - 0.7**k) for k in (1, 2, 3, 5)]


def _pattern() -> list[float]:
    """Return deviation of fixed patterns, mm, their correlation 40 pixels aside less exp(-1/4), and whether each stays."""
    effect = _made(FixedPattern)
    runs = [[_seen(FLAT, effect, number=n, seed=s) - FLAT for n in (0, 7)] for s in range(60)]
    fields = np.stack([first for first, _ in runs]).astype(float)
    aside = (fields[:, :, 40:] * fields[:, :, :-40]).mean() / (fields**2).mean()
    return [
        float(fields.std()) * 1e3,
        float(aside) - math.exp(-1 / 4),
        all(np.array_equal(first, later) for first, later in runs),
    ]


def _drifted() -> tuple[float, set[float]]:
    """Return how far drift is off 0.2 mm a minute, m, and its signs over seeds."""
    effect = _made(Drift, rate="0.2 mm/min")
    moved = [
        [float((_seen(FLAT, effect, number=30 * t, seed=s) - FLAT).mean()) for t in (0, 30, 60)] for s in range(20)
    ]
    off = np.abs(np.abs(moved) - [0, 0.1e-3, 0.2e-3]).max()
    return float(off), {float(np.sign(end)) for *_, end in moved}


def _lost_on(slope: float, turn: int) -> float:
    """Return the share of pixels lost on a plane z = d + slope x through the optical axis, of depth d / (1 - slope (u - cx) / fx)."""
    lens = CROP.cropped(160, 172, 100, 112)  # so close to the axis that the sight is along it
    across = ((np.arange(12) - lens.cx) / lens.fx, (np.arange(12) - lens.cy) / lens.fy)[turn]
    line = 0.2 / (1 - slope * across)
    depth = np.broadcast_to(line if turn == 0 else line[:, None], (12, 12)).astype(np.float32)
    return float(np.mean([_seen(depth, _made(Dropout), number=n, lens=lens) == 0 for n in range(1500)]))


def _flown() -> list[Any]:
    """Return rows of the pixels that flew, their share, whether they went to the other side, and the least and largest flights, m."""
    depth = FLAT.copy()
    depth[:, 100:] = 0.2045  # under the step that makes an edge
    depth[200:] += np.float32(0.007)
    depth[:, 150:] = 0.0
    effect = _made(FlyingPixels, share=0.2)
    moved = np.stack([_seen(depth, effect, number=n) - depth for n in range(40)])
    rows, far = np.flatnonzero(moved.any(axis=(0, 2))), np.abs(moved[moved != 0])
    towards = moved[:, 199].min() >= 0 and moved[:, 200].max() <= 0 and not moved[:, :, 150:].any()
    return [
        rows.tolist(),
        float((moved[:, 199:201, :150] != 0).mean()),
        bool(towards),
        float(far.min()),
        float(far.max()),
    ]


def _as_flown(found: list[Any]) -> bool:
    rows, share, towards, least, largest = found
    return bool(
        rows == [199, 200] and abs(share - 0.2) < 0.01 and towards and least >= 2e-3 - 1e-7 and largest <= 7e-3 + 1e-7
    )


def _flown_far() -> list[float]:
    """Return the part of pixels at an edge of 50 mm that fly, and their mean and largest flight, m."""
    moved = np.abs(_seen(EDGED, _made(FlyingPixels, share=1.0)) - EDGED)
    return [float(np.mean(moved[:, 99:101] > 0)), float(np.mean(moved[:, 99:101])), float(moved.max())]


def _in_counts(*effects: Any) -> Any:
    depth = np.array([[0.0, 0.2, 0.20006, 8.19, 9.0, 1e-9]], np.float32)
    return counts(_exposed(depth, effects, lens=CROP.cropped(0, 1, 0, 6))).tolist()


def _mean_left(memory: float, frames: int) -> float:
    lags = np.abs(np.subtract.outer(np.arange(frames), np.arange(frames)))
    return float(frames_left(memory, frames) / math.sqrt((memory**lags).mean()))


STEEP = math.tan(math.radians(57)), math.tan(math.radians(63))

CASES: tuple[Hard, ...] = (
    *group(
        "an image without pixels, of one, or narrower than a kernel",
        {
            f"{name} of {shape[0]} x {shape[1]}": (partial(_counted, name, shape), Value(shape))
            for name in EFFECTS
            for shape in SHAPES
        },
    ),
    *group(
        "noise larger than the depth, and pixels that have none",
        {f"{name} at 4 mm": (partial(_near_zero, name), Value([True] * 3)) for name in EFFECTS},
    ),
    *group(
        "an effect of size 0 must leave every digit",
        {f"{name} of nothing": (partial(_idle, name), Value(True)) for name in IDLE},
    ),
    *group(
        "gaps between pixels that are hardly ever drawn are longer than a number can hold",
        {
            f"{name} of a share of {share:g}": (partial(_hardly, name, share), Value(True))
            for name in ("dropout", "flying_pixels")
            for share in (1e-300, 1e-18, 1e-12)
        },
    ),
    *group(
        "deviations and correlations from none to all, kernels of no pixel, memories of nearly 1",
        {name: (partial(_measured, name), _as_asked(name)) for name in ASKED},
        {
            "a memory that fades": (_memory, Value([0.0] * 4, abs=0.03)),
            "a fixed pattern": (
                _pattern,
                Check(
                    "0.5 mm, smooth over 80 px, fixed", lambda f: abs(f[0] - 0.5) < 0.03 and abs(f[1]) < 0.08 and f[2]
                ),
            ),
            "drift": (
                _drifted,
                Check("0.2 mm a minute, of either sign", lambda f: f[0] < 1e-7 and f[1] == {-1.0, 1.0}),
            ),
        },
        {
            f"a mean of {frames} frames, memory {memory:g}": (partial(_mean_left, memory, frames), Value(1.0, abs=1e-9))
            for memory in (0.0, 0.3, 0.6, 0.9)
            for frames in (1, 2, 8, 100)
        },
    ),
    *group(
        "a frame must not depend on which frames were asked for before",
        {
            f"{name} in any order": (partial(_repeated, name), Value(True))
            for name in EFFECTS
            if name not in ("quantisation", "lens_distortion")
        },
    ),
    *group(
        "steep ground, edges, and depths that no count can represent",
        {
            f"dropout on a slope of {slope:.3g} {'across' if turn == 0 else 'along'}": (
                partial(_lost_on, slope, turn),
                Value(0.01 * times, rel=0.08),
            )
            for slope, times in ((0.0, 1.0), (STEEP[0], 1.0), (STEEP[1], 10.0))
            for turn in (0, 1)
        },
        {
            "pixels fly at edges only": (
                _flown,
                Check("at both rows of the edge, one in five, to the other side", _as_flown),
            ),
            "pixels fly at most 10 mm": (
                _flown_far,
                Check(
                    "all of the edge, by 6 mm in the mean",
                    lambda f: f[0] == 1 and abs(f[1] - 6e-3) < 3e-4 and f[2] <= 0.01 + 1e-7,
                ),
            ),
            "counts of quantisation": (
                partial(_in_counts, _made(Quantisation)),
                Value([[0, 1600, 1600, 65520, 0, 0]]),
            ),
            "counts without it": (_in_counts, Value([[0, 20000, 20006, 0, 0, 0]])),
        },
    ),
)
