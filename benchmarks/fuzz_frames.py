"""Frames that no camera should send, through all that looks at a frame: each must give finite numbers or a refusal with its reason.

    python benchmarks/fuzz_frames.py [FRAMES] [SEED]

Prints the outcomes by function, answers that broke the rule (exit 1), and CPU milliseconds of one core, with warm kernels, by function and size, and
at 640 x 480 by kind of frame: median, 99 in 100, most. Times are of answers and of refusals. The slowest frames are run again, since
other work on the machine also makes a call slow; the yardstick, a fixed computation, measures how fast the machine is meanwhile.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt import perception
from stretch_bt.accuracy.yardstick import yardstick
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.perception.types import INVALID
from stretch_bt.threads import one_thread
from stretch_bt.units import Estimate

Counts = npt.NDArray[np.uint16]

SIZES = ((240, 320), (480, 640))
REACH = HandGeometry().reach(0.02)
UNIT, PLANE = 0.125e-3, 0.2
PLANES = (0.01, 0.15, 0.19, 0.21, 0.3, 0.5, 1.0, 2.0)  # m, distances of the flat membrane that most frames do not fit
REFUSALS = (NoContact, IllConditioned, InvalidInput)
DEAR = (
    "find_contact",
    "segment",
    "track_height",
    "fit_contact_sphere",
    "fit_sphere",
)  # of which 50 ms are asked at 640 x 480
SLOWEST, RUNS = 8, 5  # frames that are run again, and how often


def lens(size: tuple[int, ...]) -> Intrinsics:
    """Return the intrinsics of a camera that sees 0.27 m of a membrane at PLANE."""
    (h, w), focal = size, 0.74 * size[1]
    return Intrinsics(focal, focal, (w - 1) / 2, (h - 1) / 2, w, h)


def _counts(values: Any) -> Counts:
    return np.asarray(np.rint(values).clip(0, 65535), dtype=np.uint16)


def pressed(size: tuple[int, int], rng: np.random.Generator) -> Counts:
    """Return a cap or a disc pressed into a membrane, with its skirt, noise, quantisation and some dropped pixels."""
    (h, w), focal = size, 0.74 * size[1]
    x = ((np.arange(w) - w / 2) / focal * PLANE - rng.normal(0, 5e-3))[None, :]
    y = ((np.arange(h) - h / 2) / focal * PLANE - rng.normal(0, 5e-3))[:, None]
    r, depth = np.hypot(x, y / rng.uniform(1, 1.6)), rng.uniform(0, 15e-3)
    edge = rng.uniform(3e-3, 2e-2)
    skirt = depth * np.clip(np.log(45e-3 / np.maximum(r, 1e-9)) / np.log(45e-3 / edge), 0, 1)
    bow = rng.choice([0.0, 1.0]) * (edge**2 - np.minimum(r, edge) ** 2) / rng.uniform(2 * edge, 0.08)
    image = PLANE - skirt - bow + rng.normal(0, rng.choice([1e-4, 3e-4, 1e-3]), size)
    image[rng.random(size) < 0.01] = 0
    return _counts(image / UNIT)


def few(image: Counts, rng: np.random.Generator) -> Counts:
    kept, places = np.zeros_like(image), rng.integers(0, image.size, rng.integers(0, 40))
    kept.flat[places] = rng.choice([1600, 5600, 800]) + rng.integers(0, 50, places.size)
    v, u = rng.integers(0, image.shape[0]), rng.integers(0, image.shape[1] - 1)
    kept[v, u : u + 2] = 5600
    return kept


def sparse(image: Counts, rng: np.random.Generator) -> Counts:
    return np.where(rng.random(image.shape) < rng.uniform(0, 0.3), image, 0).astype(np.uint16)


def salt(image: Counts, rng: np.random.Generator) -> Counts:
    low, high = ((0, 65535), (1000, 1800), (1500, 1700))[rng.integers(3)]
    return np.where(rng.random(image.shape) < rng.uniform(0, 0.6), rng.integers(low, high, image.shape), image).astype(
        np.uint16
    )


def blocks(image: Counts, rng: np.random.Generator) -> Counts:
    holed, (h, w) = image.copy(), image.shape
    for _ in range(rng.integers(1, 40)):
        v, u, n, m = rng.integers(0, h), rng.integers(0, w), rng.integers(1, h // 2), rng.integers(1, w // 2)
        holed[v : v + n, u : u + m] = rng.choice([0, 0, 0, 65535, 1])
    return holed


def constant(image: Counts, rng: np.random.Generator) -> Counts:
    return np.full_like(image, rng.choice([0, 1, 8, 800, 1500, 1600, 1700, 5600, 30000, 65535]))


def steps(image: Counts, rng: np.random.Generator) -> Counts:
    wide, high = rng.integers(1, 80), rng.choice([1, 10, 100, 1000])
    ramp = np.arange(image.shape[1]) // wide * high
    return _counts(1400 + ramp[None, :] + 0 * image)


def stripes(image: Counts, rng: np.random.Generator) -> Counts:
    a, b = rng.integers(1, 40, 2)
    u, v = np.arange(image.shape[1]) // a % 2, np.arange(image.shape[0]) // b % 2
    pattern = (u[None, :] ^ v[:, None], u[None, :] | 0 * v[:, None], u[None, :] & v[:, None])[rng.integers(3)]
    return _counts(1600 - rng.choice([5, 20, 100, 1600]) * pattern)


def dots(image: Counts, rng: np.random.Generator) -> Counts:
    """Return a bed of bumps: many places that are truly curved."""
    period = rng.integers(6, 60)
    u, v = (np.cos(2 * np.pi * np.arange(n) / period) for n in image.shape[::-1])
    rough = rng.normal(0, rng.choice([0, 2]), image.shape)
    return _counts(1560 - rng.choice([3, 10, 40]) * v[:, None] * u[None, :] + rough)


def noise(image: Counts, rng: np.random.Generator) -> Counts:
    low, high = ((0, 65535), (1, 3000), (1400, 1700), (1550, 1650))[rng.integers(4)]
    return rng.integers(low, high, image.shape).astype(np.uint16)


def corner(image: Counts, rng: np.random.Generator) -> Counts:
    """Return a pressed membrane of which a corner is at another distance, or a box that meets two edges of the image."""
    (h, w), found = image.shape, image.copy()
    v, u = int(h * rng.uniform(0.1, 0.9)), int(w * rng.uniform(0.1, 0.9))
    found[v:, u:] = rng.choice([800, 1300, 1500, 1550, 1590, 2400])
    return np.asarray(found[:: rng.choice([-1, 1]), :: rng.choice([-1, 1])])


def stairs(image: Counts, rng: np.random.Generator) -> Counts:
    """Return steps along one or two axes or around the middle, with or without noise and holes."""
    h, w = image.shape
    u, v = np.arange(w)[None, :], np.arange(h)[:, None]
    wide, high = rng.integers(8, 120), rng.choice([2, 5, 20, 60, 200])
    shapes = (u + 0 * v, u + v, np.maximum(abs(u - w // 2), abs(v - h // 2)), np.hypot(u - w // 2, v - h // 2))
    level = shapes[rng.integers(4)] // wide + (v // wide if rng.random() < 0.3 else 0)
    made = (
        1600
        + rng.choice([-1, 1]) * high * (level - rng.integers(0, 4))
        + rng.normal(0, rng.choice([0, 0, 1, 3]), image.shape)
    )
    made[rng.random(image.shape) < rng.choice([0, 0, 0.02])] = 0
    return _counts(made)


def fractal(image: Counts, rng: np.random.Generator) -> Counts:
    """Return a pattern whose holes have holes, of all sizes."""
    v, u = np.indices(image.shape)
    both = u & v if rng.random() < 0.7 else u & v & ~7
    shift = rng.integers(0, 5)
    near, far = rng.choice([1500, 1550, 1580]), rng.choice([1590, 1600, 1620])
    counts: Counts = np.where((both >> shift) == 0, near, far).astype(np.uint16)
    return counts


def mesas(image: Counts, rng: np.random.Generator) -> Counts:
    """Return a few large raised places side by side, flat, round or rough, as many as still count as objects."""
    (h, w), (rows, columns) = image.shape, ((1, 1), (1, 3), (2, 2), (2, 4), (3, 3), (2, 5))[rng.integers(6)]
    u, v = (np.arange(n) * m / n % 1 - 0.5 for n, m in ((w, columns), (h, rows)))
    share, high = rng.uniform(0.2, 0.49), rng.choice([10, 40, 120])
    away = np.maximum(abs(u)[None, :], abs(v)[:, None]) if rng.random() < 0.5 else np.hypot(u[None, :], v[:, None])
    lifted = np.where(away < share, 1.0, 0.0) if rng.random() < 0.6 else np.clip(1 - (away / share) ** 2, 0, 1)
    return _counts(1600 - high * lifted + rng.normal(0, rng.choice([0, 1, 4]), image.shape))


KINDS: dict[str, Callable[[Counts, np.random.Generator], Counts]] = {
    "few": few, "sparse": sparse, "salt": salt, "blocks": blocks, "constant": constant, "steps": steps, "stripes": stripes,
    "dots": dots, "noise": noise, "corner": corner, "stairs": stairs, "fractal": fractal, "mesas": mesas,
}  # fmt: skip


def odd_lens(whole: Intrinsics, rng: np.random.Generator) -> Intrinsics:
    """Return intrinsics that are wrong in one or two numbers."""
    wrong = [0.0, -1.0, 1e-9, 1e-3, 1.0, 30.0, 1e5, 1e12, math.nan, math.inf]
    names = rng.choice(["fx", "fy", "cx", "cy"], rng.integers(1, 3), replace=False)
    changed: dict[str, Any] = {name: float(rng.choice(wrong)) for name in names.tolist()}
    if rng.random() < 0.3:
        changed["distortion"] = tuple(rng.normal(0, rng.choice([0.1, 10, 1e6]), 5).tolist())
    return dataclasses.replace(whole, **changed)


def odd_array(depth: npt.NDArray[Any], rng: np.random.Generator) -> Any:
    """Return a depth image, m, as an array of another kind, order, type or shape."""
    makers: list[Callable[[], Any]] = [
        lambda: depth.astype(">f4"),
        lambda: depth.astype("g"),
        lambda: depth.astype("f2"),
        lambda: depth.astype(np.uint16),
        lambda: depth.astype(complex),
        lambda: depth[::-1, ::-1],
        lambda: np.asfortranarray(depth),
        lambda: depth[:40, :30].tolist(),
        lambda: depth[None],
        lambda: depth.ravel(),
        lambda: [[0.2, 0.2], [0.2]],
        lambda: depth * 1e30,
        lambda: depth * 1e-30,
        lambda: np.where(rng.random(depth.shape) < 0.3, rng.choice([np.nan, np.inf, -np.inf, -1.0, 1e38]), depth),
        lambda: None,
        lambda: "depth",
    ]
    return makers[rng.integers(len(makers))]()


def faulty(found: Any, name: str = "") -> str:
    """Return the part of an answer that is not finite or has a deviation that is not above 0, or nothing."""
    if dataclasses.is_dataclass(found) and not isinstance(found, type):
        values = ((f.name, getattr(found, f.name)) for f in dataclasses.fields(found))
        return next((bad for n, v in values if (bad := faulty(v, n))), "")
    if isinstance(found, Estimate) and (bad := faulty(found.sd, f"{name}.sd")):
        return bad
    if isinstance(found, tuple):
        return next((bad for v in found if (bad := faulty(v, name))), "")
    if isinstance(found, float | np.floating) or (isinstance(found, np.ndarray) and found.dtype.kind == "f"):
        if not np.isfinite(found).all():
            return f"{name} is not finite"
        if name.endswith("sd") and np.any(np.asarray(found) <= 0):
            return f"{name} is not above 0"
    return ""


class Fuzz:
    """Outcomes and times of all functions on all frames."""

    def __init__(self) -> None:
        self.outcomes: dict[str, Counter[str]] = defaultdict(Counter)
        self.times: dict[tuple[str, int], list[tuple[float, str, int]]] = defaultdict(list)
        self.yardsticks: list[float] = []
        self.broken: list[str] = []
        self.kind, self.number, self.height = "", 0, 0

    def call(self, name: str, function: Callable[[], Any], check: Callable[[Any], str] = faulty) -> Any:
        """Call a function, note its outcome and time, and return its answer or None."""
        began, found = time.process_time(), None
        try:
            found = function()
            bad = check(found)
            outcome = "answer"
        except REFUSALS as error:
            outcome, bad = type(error).__name__, "" if len(str(error)) > 20 else f"hardly a reason: {error}"
        except Exception as error:
            outcome, bad = "BROKEN", f"{type(error).__name__}: {error}"
        self.times[name, self.height].append((1e3 * (time.process_time() - began), self.kind, self.number))
        self.outcomes[f"{name:20s}"][outcome] += 1
        if bad:
            self.broken.append(f"{self.kind}, frame {self.number}, {name}: {bad}")
        return found

    def cloud(self, depth: Any, intrinsics: Any) -> None:
        """Deproject and segment an array."""
        found = self.call("deproject", lambda: perception.deproject(depth, intrinsics), _cloud_faulty)
        if found is not None:
            self.call("segment", lambda: perception.segment(*found))

    def frame(self, frame: DepthFrame, rule: Any) -> None:
        """Run what nodes run on a frame."""
        self.call("mask_membrane", lambda: perception.mask_membrane(frame, gauge=0.1, width=0.09, stretch=0.02))
        self.call("average_frames", lambda: perception.average_frames([frame] * 4))
        contact = self.call("find_contact", lambda: perception.find_contact(frame, rule=rule), _contact_faulty)
        if contact is None:
            return
        self.call("fit_contact_sphere", lambda: perception.fit_contact_sphere(contact))
        few = slice(None, None, max(1, len(contact.points) // 4000))
        points, rays = contact.points[few], contact.rays[few]
        self.call("fit_sphere", lambda: perception.fit_sphere(points, rays=rays, noise=contact.surface_noise))
        valid = contact.labels != INVALID
        self.call("track_height", lambda: perception.track_height(contact.surface, valid, contact.labels, reach=REACH))
        self.call("contact_width", lambda: perception.contact_width(contact.surface, contact.labels))
        self.call("contact_outline", lambda: perception.contact_outline(contact))
        noise = contact.surface_noise
        self.call("outline_at", lambda: perception.outline_at(contact.surface, 1.5e-3, noise=noise))
        self.call("measure_contact", lambda: perception.measure_contact(contact.surface, contact.labels))

    def series(self, frames: list[DepthFrame]) -> None:
        """Run what follows frames in time."""
        for name, follower in (
            ("HeightTracker", perception.HeightTracker()),
            ("ContactDetector", perception.ContactDetector()),
        ):
            for frame in frames:
                self.call(name, partial(follower.update, frame))


def _cloud_faulty(found: Any) -> str:
    points, valid = found
    return "" if np.isfinite(points[valid]).all() else "a valid point is not finite"


def _contact_faulty(contact: Any) -> str:
    seen = contact.labels != INVALID
    parts = contact.points, contact.rays, contact.confidence, contact.surface[seen], contact.noise, contact.noise_area
    return faulty(parts, "a part of the contact")


def warm(fuzz: Fuzz) -> None:
    """Run all once, so that no time counts imports or compilation."""
    for size in SIZES:
        for seed in range(8):
            raw = pressed(size, np.random.default_rng(seed))
            frame = DepthFrame(raw, UNIT, lens(size), 0.0, 0, PLANE)
            fuzz.cloud(frame.depth, frame.intrinsics)
            fuzz.frame(frame, "mean")
            fuzz.series([frame] * 8)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 5000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    warnings.simplefilter("error")
    with one_thread():  # as runs hold it
        _run(count, seed)


@dataclasses.dataclass
class Drawn:
    """What one frame is made of; a number and a seed give the same again."""

    kind: str
    raw: Counts
    unit: float
    plane: float
    rng: np.random.Generator


def drawn(number: int, seed: int) -> Drawn:
    """Return the frame of a number."""
    rng, size = np.random.default_rng((seed, number)), SIZES[number % 2]
    kind = str(rng.choice([*KINDS, "pressed", "pressed", "lens", "array", "scale"]))
    raw, unit, plane = pressed(size, rng), UNIT, PLANE
    if kind in KINDS:
        raw = KINDS[kind](raw, rng)
        plane = float(rng.choice(PLANES)) if rng.random() < 0.4 else PLANE
    if kind == "scale":
        unit = float(rng.choice([1e-30, 1e-6, 1e-5, 1e-4, 1e-3, 1.0, 1e30, 0.0, math.nan]))
        plane = float(rng.choice([0.2, 0.0, -0.2, 1e-9, 5.0, 1e30, math.nan]))
    return Drawn(kind, raw, unit, plane, rng)


def _run(count: int, seed: int) -> None:
    warm(Fuzz())
    fuzz, last = Fuzz(), list[DepthFrame]()
    for number in range(count):
        frame = look(fuzz, number, seed)
        if frame is not None:
            last = [f for f in last[-7:] if f.raw.shape == frame.raw.shape] + [frame]
            if number % 25 < 2:
                fuzz.series([frame] * 6 + last)
        if number % 25 == 0:
            fuzz.yardsticks.append(1e3 * yardstick())
    report(fuzz, count)
    slowest(fuzz, seed)
    raise SystemExit(1 if fuzz.broken else 0)


def look(fuzz: Fuzz, number: int, seed: int) -> DepthFrame | None:
    """Draw a frame and run all on it; return it, or None where it is refused."""
    made = drawn(number, seed)
    raw, intrinsics = made.raw, lens(made.raw.shape)
    fuzz.kind, fuzz.number, fuzz.height = made.kind, number, len(raw)
    wrong = made.kind == "lens"
    known = fuzz.call("Intrinsics", partial(odd_lens, intrinsics, made.rng)) if wrong else intrinsics
    if made.kind == "array":
        fuzz.cloud(odd_array(raw * UNIT, made.rng), known)
    frame: DepthFrame | None = None
    if known is not None:
        make = partial(DepthFrame, raw, made.unit, known, 0.0, number, made.plane, 0.1, 0.02)
        frame = fuzz.call("DepthFrame", make, lambda _: "")
    if frame is None:
        return None
    if made.kind != "array":
        fuzz.cloud(frame.depth, frame.intrinsics)
    fuzz.frame(frame, "either" if number % 8 > 5 else "mean")
    return frame


def row(name: str, of: object, times: list[tuple[float, str, int]]) -> str:
    """Return a row of a table: how many calls, and their median, 99 in 100, and most."""
    ms, (_, kind, number) = np.array([t for t, _, _ in times]), max(times)
    shares = f"{np.median(ms):7.2f} {np.quantile(ms, 0.99):7.2f} {ms.max():7.2f}"
    return f"{name:20s} {of!s:>8s} {len(ms):6d} {shares}  {kind}, frame {number}"


def report(fuzz: Fuzz, count: int) -> None:
    """Print outcomes, times and what broke the rule."""
    print(f"{count} frames")
    for name, outcomes in fuzz.outcomes.items():
        print(name, dict(outcomes.most_common()))
    print(f"\n{'CPU ms':20s}     rows  calls  median     p99     max  the longest is of")
    for (name, height), times in sorted(fuzz.times.items()):
        print(row(name, height, times))
    print(f"\n{'CPU ms, 640 x 480':20s}     kind  calls  median     p99     max  the longest is of")
    for name in DEAR:
        kinds = defaultdict(list)
        for found in fuzz.times[name, SIZES[-1][0]]:
            kinds[found[1]].append(found)
        for kind, times in sorted(kinds.items()):
            print(row(name, kind, times))
    for line, n in Counter(fuzz.broken).most_common(40):
        print(f"BROKEN {n} x {line}")


def slowest(fuzz: Fuzz, seed: int) -> None:
    """Print the least times of the slowest frames in some more runs."""
    print(
        f"\nthe slowest {SLOWEST} frames of 640 x 480, the least of {RUNS} more runs of each, CPU ms; yardstick {np.median(fuzz.yardsticks):.1f}"
    )
    for name in DEAR:
        least = []
        for _, kind, number in sorted(fuzz.times[name, SIZES[-1][0]])[-SLOWEST:]:
            again = Fuzz()
            for _ in range(RUNS):
                look(again, number, seed)
            least.append((min(again.times[name, SIZES[-1][0]])[0], f"{kind}, frame {number}"))
        print(f"{name:20s}", ", ".join(f"{ms:.0f} ({what})" for ms, what in sorted(least, reverse=True)))


if __name__ == "__main__":
    main()
