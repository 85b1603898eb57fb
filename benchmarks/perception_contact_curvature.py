"""The curvature under a contact, with its stated deviation; run as `python benchmarks/perception_contact_curvature.py [draws]`.

The membrane is a study of its own: a neo-Hookean sheet stretched alike in all directions over a body of revolution, by the
equations of equilibrium from the pole outwards (no shooting: the stretch at the pole and the angle where the sheet leaves the
body are drawn, and the clamp is where the sheet ends). Radii of 5 to 40 mm, caps of 10 to 60 degrees, flat cylinders with
a rounded edge, and cones, off the middle and tilted, through a pinhole camera, with dropouts, flying pixels and counts of
0.125 mm. Held to: rms of error over stated 0.7 to 1.3, no answer beyond five deviations in 2000, no cone answered, and
of the caps whose Cramer-Rao bound (pixels that touch, the covariance of the noise with 1 % of it white) is under a
tenth at least 90 % answered, with a stated deviation of at most two bounds.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import cho_factor, cho_solve
from scipy.ndimage import gaussian_filter

from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import find_contact, fit_contact_sphere

CAMERA = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333)
PLANE_DISTANCE = 0.2
UNIT = 0.125e-3
EDGE = 60e-3  # m from the axis, up to which the sheet is drawn
CELLS = 600  # groups of touching pixels, about, whose means give the bound

Curve = Callable[
    [float], tuple[float, float]
]  # arc length, m -> angle, rad, and curvature, 1/m, of the body's meridian


@dataclass(frozen=True)
class Body:
    """A body of revolution: its meridian, the curvature of its top, 1/m, None where it has none, and where it is left."""

    kind: str
    meridian: Curve
    curvature: float | None
    left: float  # arc length, m, at which the sheet leaves it


@dataclass(frozen=True)
class Noise:
    """White noise, m; smooth noise, m, after a Gaussian of `kernel` pixels; and how much its size changes from place to place."""

    name: str
    white: float = 0.0
    smooth: float = 0.0
    kernel: float = 3.0
    uneven: float = 0.0

    @property
    def sd(self) -> float:
        """Of one pixel, m."""
        return float(np.hypot(self.white, self.smooth))


NOISES = (
    Noise("white 0.3", white=0.3e-3),
    Noise("white 0.5", white=0.5e-3),
    Noise("white 1.0", white=1e-3),
    Noise("smooth 0.3", white=0.03e-3, smooth=0.3e-3, kernel=3.0),
    Noise("SR305-like", white=0.02e-3, smooth=0.2e-3, kernel=1.1, uneven=0.4),
    Noise("both 0.3", white=0.3e-3, smooth=0.2e-3, kernel=2.5),
)


def sphere(rng: np.random.Generator) -> Body:
    while True:
        radius, angle = np.exp(rng.uniform(np.log(5e-3), np.log(40e-3))), np.radians(rng.uniform(10.0, 60.0))
        if radius * np.sin(angle) < 25e-3:
            return Body("sphere", partial(_arc, radius), 1.0 / radius, radius * angle)


def _arc(radius: float, s: float) -> tuple[float, float]:
    return s / radius, 1.0 / radius


def face(rng: np.random.Generator) -> Body:
    inner, fillet, angle = rng.uniform(4e-3, 15e-3), rng.uniform(0.5e-3, 1.5e-3), np.radians(rng.uniform(10.0, 50.0))

    def meridian(s: float) -> tuple[float, float]:
        return (0.0, 0.0) if s < inner else ((s - inner) / fillet, 1.0 / fillet)

    return Body("face", meridian, 0.0, inner + fillet * angle)


def cone(rng: np.random.Generator) -> Body:
    tip, angle, length = rng.uniform(0.3e-3, 1e-3), np.radians(rng.uniform(15.0, 50.0)), rng.uniform(4e-3, 14e-3)

    def meridian(s: float) -> tuple[float, float]:
        return (s / tip, 1.0 / tip) if s < tip * angle else (angle, 0.0)

    return Body("cone", meridian, None, length)


BODIES = {"sphere": sphere, "face": face, "cone": cone}


@dataclass(frozen=True)
class Sheet:
    """The sheet's height below its top, m, by the distance from its axis, m; where it leaves the body; and its lowest place."""

    height: CubicHermiteSpline
    rim: float
    end: float


def sheet(body: Body, pole: float) -> Sheet:
    """Solve a neo-Hookean sheet over a body, stretched by `pole` on its axis: W = (l1^2 + l2^2 + 1 / (l1 l2)^2 - 3) / 2."""

    def tensions(l1: float, l2: float) -> tuple[float, float, float]:
        i = 1.0 / (l1 * l2) ** 2
        return l1 - i / l1, l2 - i / l2, i

    def rates(big: float, state: Any) -> list[float]:
        l1, l2, phi, _, arc, touching = state
        n1, n2, i = tensions(l1, l2)
        if touching > 0.5:
            phi, bend = body.meridian(arc)
            d_phi = l1 * bend
        else:
            d_phi = -n2 * np.sin(phi) / (big * n1)
        d2 = (l1 * np.cos(phi) - l2) / big
        d1 = ((n2 * np.cos(phi) - n1) / big - 2.0 * i / (l1 * l2) * d2) / (1.0 + 3.0 * i / l1**2)
        return [d1, d2, d_phi, -l1 * np.sin(phi), l1, 0.0]

    def leaves(_: float, state: Any) -> float:
        return float(state[4] - body.left)

    def ends(big: float, state: Any) -> float:
        return float(state[1] * big - EDGE)

    leaves.terminal = ends.terminal = True  # type: ignore[attr-defined]
    first = 1e-5
    options: dict[str, Any] = {"rtol": 1e-9, "atol": 1e-12, "max_step": 0.5e-3}
    inner = solve_ivp(rates, (first, 0.2), [pole, pole, 0.0, 0.0, pole * first, 1.0], events=leaves, **options)
    at = inner.y[:, -1].copy()
    at[2], at[5] = body.meridian(body.left)[0], 0.0
    outer = solve_ivp(rates, (inner.t[-1], 0.4), at, events=ends, **options)
    big = np.concatenate([inner.t, outer.t[1:]])
    state = np.concatenate([inner.y, outer.y[:, 1:]], axis=1)
    slopes = np.concatenate([[body.meridian(s)[0] for s in inner.y[4]], outer.y[2, 1:]])
    r, z = big * state[1], state[3]
    r, z, slopes = np.r_[0.0, r], np.r_[0.0, z], np.r_[0.0, slopes]
    return Sheet(CubicHermiteSpline(r, z, -np.tan(slopes)), float(inner.t[-1] * inner.y[1, -1]), float(z[-1]))


@dataclass(frozen=True)
class View:
    """What the camera would see without noise: depth (h, w), m, and which pixels touch."""

    body: Body
    depth: Any
    touching: Any


def rendered(body: Body, pole: float, at: Any, tilt: Any) -> View:
    """Return what a pinhole sees of a sheet whose axis stands at `at` (2,), m, and leans by `tilt` (2,), rad."""
    found = sheet(body, pole)
    slope = found.height.derivative()
    u, v = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    axis = np.array([tilt[0], tilt[1], 1.0]) / np.sqrt(1.0 + tilt @ tilt)
    e1 = np.array([axis[2], 0.0, -axis[0]]) / np.hypot(axis[2], axis[0])
    e2 = np.cross(axis, e1)
    ray = np.stack([x, y, -np.ones_like(x)], axis=-1)  # per metre of depth, z up
    start = np.array([-at[0], -at[1], PLANE_DISTANCE + found.end])  # of the camera, from the top of the sheet
    depth = np.full(x.shape, PLANE_DISTANCE + 0.5 * found.end)
    for _ in range(25):
        p = start + depth[..., None] * ray
        across = p @ e1, p @ e2
        r = np.minimum(np.hypot(*across), EDGE - 1e-6)
        off = p @ axis - found.height(r)
        by = ray @ axis - slope(r) * (across[0] * (ray @ e1) + across[1] * (ray @ e2)) / np.maximum(r, 1e-9)
        step = np.clip(off / np.minimum(by, -0.2), -5e-3, 5e-3)
        depth -= step
        if np.abs(step).max() < 1e-8:
            break
    p = start + depth[..., None] * ray
    return View(body, depth, np.hypot(p @ e1, p @ e2) < found.rim)


def drawn(kind: str, rng: np.random.Generator) -> View:
    """Draw a press; one whose sheet tears or folds is drawn again."""
    while True:
        try:
            body, pole = BODIES[kind](rng), rng.uniform(1.05, 1.5)
            at, tilt = rng.uniform(-8e-3, 8e-3, 2), np.radians(rng.normal(0.0, 1.5, 2))
            return rendered(body, pole, at, tilt)
        except ValueError:
            continue


def smooth(shape: tuple[int, ...], kernel: float, rng: np.random.Generator) -> Any:
    margin = int(4 * kernel) + 1
    wide = rng.standard_normal((shape[0] + 2 * margin, shape[1] + 2 * margin))
    return (2.0 * np.sqrt(np.pi) * kernel * gaussian_filter(wide, kernel))[margin:-margin, margin:-margin]


def observed(view: View, noise: Noise, rng: np.random.Generator) -> DepthFrame:
    """Return a frame with noise, 1 % of dropouts, 0.1 % of flying pixels and counts."""
    shape = view.depth.shape
    error = noise.white * rng.standard_normal(shape)
    if noise.smooth:
        part = noise.smooth * smooth(shape, noise.kernel, rng)
        if noise.uneven:
            part *= np.exp(noise.uneven * smooth(shape, 12.0, rng)) / np.exp(noise.uneven**2)
        error += part
    flying = rng.random(shape) < 1e-3
    error[flying] += rng.uniform(-20e-3, 20e-3, int(flying.sum()))
    counts = np.rint((view.depth + error) / UNIT)
    raw = np.where(rng.random(shape) < 0.01, 0, counts).astype(np.uint16)
    return DepthFrame(raw, UNIT, CAMERA, 0.0, 0, PLANE_DISTANCE, hand_height=0.0, stretch=None)


def bound(view: View, noise: Noise) -> float:
    """Return the Cramer-Rao bound of the curvature, over it, by the pixels that touch alone."""
    rows, columns = np.nonzero(view.touching)
    side = max(1, int(np.ceil(np.sqrt(len(rows) / CELLS))))
    key = (rows // side) * 1000 + columns // side
    _, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
    v, u = (np.bincount(inverse, w) / count for w in (rows, columns))
    depth = np.bincount(inverse, view.depth[rows, columns]) / count
    k = view.body.curvature
    assert k
    x, y = (u - CAMERA.cx) * depth / CAMERA.fx, (v - CAMERA.cy) * depth / CAMERA.fy
    x, y = x - x.mean(), y - y.mean()
    root = np.sqrt(np.maximum(1.0 - k * k * (x * x + y * y), 0.05))
    scale = np.sqrt(x.var() + y.var())
    by_k = (x * x + y * y) / (root * (1.0 + root)) / 1.0
    jacobian = np.stack([np.ones_like(x), k * x / root, k * y / root, by_k / scale**2], axis=1)
    apart = (u[:, None] - u) ** 2 + (v[:, None] - v) ** 2
    white = max(noise.white**2 + UNIT**2 / 12.0, 0.01 * noise.sd**2)
    if noise.smooth:
        spread = noise.kernel**2 + side**2 / 12.0  # means over squares blur as a Gaussian of their variance
        alike = noise.smooth**2 * noise.kernel**2 / spread * np.exp(-apart / (4.0 * spread))
    else:
        alike = np.zeros_like(apart)
    covariance = alike + np.diag(white / count)
    information = jacobian.T @ cho_solve(cho_factor(covariance), jacobian)
    return float(np.sqrt(np.linalg.inv(information)[3, 3]) / scale**2 / k)


@dataclass
class Answers:
    """Of one family: (curvature, stated, true, bound) of what was answered, how many were not, with their bounds, and CPU, ms."""

    given: list[tuple[float, float, float, float]]
    refused: list[float]
    times: list[float]
    reasons: list[str]


def family(kind: str, noise: Noise, draws: int, first: int = 0) -> Answers:
    """Measure one family."""
    answers = Answers([], [], [], [])
    for seed in range(first, first + draws):
        rng = np.random.default_rng([seed, 71])
        view = drawn(kind, rng)
        frame = observed(view, noise, np.random.default_rng([seed, 72]))
        k = view.body.curvature
        least = bound(view, noise) if k else np.inf
        try:
            contact = find_contact(frame)
            began = time.process_time()
            try:
                fit = fit_contact_sphere(contact)
                answers.given.append((fit.curvature, fit.curvature_sd, np.nan if k is None else k, least))
            finally:
                answers.times.append(1e3 * (time.process_time() - began))
        except NoAnswer as error:
            answers.refused.append(least)
            answers.reasons.append(error.reason)
    return answers


HEAD = f"{'family':22s} answered  rms(err/stated)  >3 sd  >5 sd  clear  answered  stated/bound (median, <=2)  rms/bound  ms (median, most)"


def row(kind: str, noise: Noise, answers: Answers) -> str:
    """Return the figures of one family."""
    given = np.array(answers.given).reshape(-1, 4)
    score = (given[:, 0] - given[:, 2]) / given[:, 1]
    text = f"{kind + ', ' + noise.name:22s} {len(given):8d}"
    times = f"{np.median(answers.times):6.1f} {np.max(answers.times):5.1f}" if answers.times else ""
    if kind == "cone" or not len(given):
        return f"{text}  {'':60s} {times}"
    text += f"  {np.sqrt(np.mean(score**2)):15.2f}  {np.sum(np.abs(score) > 3):5d}  {np.sum(np.abs(score) > 5):5d}"
    if kind == "sphere":
        clear = given[given[:, 3] < 0.1]
        all_clear = len(clear) + sum(b < 0.1 for b in answers.refused)
        ratio = clear[:, 1] / clear[:, 2] / clear[:, 3]
        error = (clear[:, 0] / clear[:, 2] - 1.0) / clear[:, 3]
        good = np.sum(ratio <= 2.0)
        text += (
            f"  {all_clear:5d}  {len(clear) / max(all_clear, 1):8.2f}  {np.median(ratio):6.2f}"
            f" {good / max(all_clear, 1):8.2f} {'':12s} {np.sqrt(np.mean(error**2)):6.2f}"
        )
    else:
        text += " " * 60
    return f"{text}  {times}"


def rows(draws: int, kinds: list[str], noises: list[Noise]) -> Iterator[str]:
    yield HEAD
    for kind in kinds:
        for noise in noises:
            yield row(kind, noise, family(kind, noise, draws))


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    for text in rows(draws, list(BODIES), list(NOISES)):
        print(text, flush=True)


if __name__ == "__main__":
    main()
