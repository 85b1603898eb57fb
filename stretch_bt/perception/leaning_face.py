"""A flat face that leans, and the membrane that hangs from it, fitted to the heights around a contact.

Noise lets the high side of such a face alone pass for contact. The face ends where the membrane falls off its plane, on all sides: its outline is
a superellipse, and what the membrane has fallen below the plane grows with the distance from it as log(1 + d) and as d^2, differently in different
directions. The parts of the fall and of the plane follow from those of the outline by linear least squares (variable projection; Golub and Pereyra,
1973), so that Levenberg and Marquardt's steps change the outline alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.leaning import STEEPEST, Lean, radius_of
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.types import FloatArray, MaskArray
from stretch_bt.units import Estimate

__all__ = ["BESIDE", "MOST_CELLS", "PAST", "Around", "Face", "face_around", "face_of"]

Array = npt.NDArray[np.float64]

POWER = 4.0  # of the superellipse: 2 is an ellipse, infinity a rectangle
EDGE = 1e-3  # m, over which the membrane leaves the plane
BESIDE, PAST = 2.5, 12e-3  # radii of the contact, and m, around its middle within which heights are fitted
MOST_CELLS, LEAST_CELLS = 1000, 60
NARROWEST, WIDEST = 2e-3, 28e-3  # m, half a face
FARTHEST = 20e-3  # m, of the middle of a face from the contact's
# where fits begin: radii of the contact aside and wide, and a turn, rad; so many rounds are taken from all, the others from the better BEST
STARTS = ((0.0, 1.0, 0.0), (0.7, 1.5, 0.0), (0.7, 1.5, 0.8), (1.3, 2.0, 0.0))
FIRST_ROUNDS, ROUNDS, BEST = 3, 30, 2
DAMPINGS = 6  # that are tried in a round
SETTLED = 1e-4  # gain in the squares left, below which a fit has settled
STEPS: Array = np.diag([1e-4, 1e-4, 1e-2, 1e-2, 1e-2])  # of differences along the parts of an outline
TINY = 1e-9
RING = (1.2, 2.2)  # radii of the contact, of the ring around it that is higher on the side of the face
# m, of the slope of the ring times the radius: faces that do not lean stay below, and below so many times that where the contact is round or
# two; and standard deviations of the mean of a contact
ASKEW, NOT_FLAT, BY_CHANCE = 0.12e-3, 4.0, 1.5
MOST_APART = 4.0  # times that: heights of contact and face, which over faces that do not lean differ by more where some are found
LEAST_SLOPE = 0.03
BESIDE_PLANE = 0.25e-3  # m, of a contact beside the plane of its face, past three standard deviations
UNEVEN, LIKELY = 0.03, 2.5  # difference of the slopes of a contact and its face, past so many standard deviations
LEAST_AREA, ROUND = (
    0.5,
    1.5,
)  # squared radii of a flat contact, and of one that is round or two, that half a face times the other must hold
# Standard deviation of the height: parts of the distance between the heights of contact and face, and of the rise of the face over half its
# width; and, where no face is found, of the radius of the contact, most of it at such a slope of the ring. Set over the first 24 surfaces of each
# row of `python benchmarks/leaning_tops.py`.
OFF, EXTENT, UNSEEN, SOON = 0.4, 0.3, 0.15, 0.04
NONE = Lean(None, 0.0)


@dataclass(frozen=True, slots=True)
class Face:
    """Height of a face in its middle, m, slopes along x and y, its middle (2,) and half its width and length, m, and their turn, rad."""

    height: float
    slopes: Array
    middle: Array
    half: tuple[float, float]
    turn: float

    @property
    def slope(self) -> float:
        """How steep it is."""
        return float(np.hypot(*self.slopes))

    @property
    def area(self) -> float:
        """Half its width times half its length, m^2."""
        return self.half[0] * self.half[1]

    def at(self, place: Array) -> float:
        """Return the height of its plane at a place (2,), m."""
        return self.height + float(self.slopes @ (place - self.middle))


@dataclass(frozen=True, slots=True)
class Around:
    """A contact around which a face is looked for: its radius, m, and the height of its middle, m.

    `slope` is the slopes along x and y of its plane, with their standard deviation, where it lies in one; `flat` is False for a contact that looks
    like a round top, as the high corner of a block does, or like two.
    """

    radius: float
    height: Estimate
    slope: tuple[Array, float] | None
    flat: bool = True

    @property
    def is_level(self) -> bool:
        """Whether it is known not to lean."""
        return self.slope is not None and float(np.hypot(*self.slope[0])) + 3.0 * self.slope[1] < LEAST_SLOPE

    def is_of(self, face: Face) -> bool:
        """Whether a face leans clearly, as a top does, and the contact is part of it."""
        narrow, wide = sorted(face.half)
        return bool(
            LEAST_SLOPE < face.slope < STEEPEST
            and narrow > 1.5 * NARROWEST
            and wide < 0.9 * WIDEST
            and face.area > (LEAST_AREA if self.flat else ROUND) * self.radius**2
            and abs(self.height.value - face.at(np.zeros(2))) < 3.0 * self.height.sd + BESIDE_PLANE
            and (not self.flat or self._agrees(face))
        )

    def _agrees(self, face: Face) -> bool:
        if self.slope is None:
            return True
        slopes, sd = self.slope
        return float(np.hypot(*(face.slopes - slopes))) < LIKELY * sd + UNEVEN


def face_of(
    points: FloatArray,
    valid: MaskArray,
    touching: MaskArray,
    noise: NoiseSpectrum,
    top: Estimate,
    slope: tuple[Array, float] | None,
    *,
    flat: bool,
) -> Lean:
    """Return how the flat face leans of which the pixels in contact (h, w) are the high side, where the membrane around them shows one.

    Parameters
    ----------
    top
        Height of the middle of the contact, m.
    slope
        Slopes along x and y of the plane of the contact, with their standard deviation, where it lies in one.
    flat : bool
        Whether the contact looks like one flat top, not a round one as the high corner of a block does, or two.
    """
    there = touching & valid
    contact, radius = np.median(points[there].astype(np.float64), axis=0), radius_of(points, there)
    around = Around(radius, Estimate(float(contact[2]), top.sd), slope, flat)
    if around.is_level:
        return NONE
    cells = _cells(points, valid, contact[:2], BESIDE * radius + PAST)
    by_chance = BY_CHANCE * math.sqrt(noise.of_mean(int(np.count_nonzero(there))))
    face, askew = face_around(cells - [contact[0], contact[1], 0.0], around, by_chance)
    if face is None:
        return Lean(None, UNSEEN * radius * (1.0 - math.exp(-askew / (SOON * radius))))
    sd = math.hypot(top.sd, OFF * (top.value - face.height), EXTENT * face.slope * math.sqrt(face.area))
    return Lean(Estimate(face.height, sd), 0.0)


def face_around(cells: Array, contact: Around, by_chance: float = 0.0) -> tuple[Face | None, float]:
    """Return the face that leans under a contact around 0, by heights (n, 3), m, around it.

    With None comes how far the slope of the ring times the radius is past that of faces that do not lean, m, and past chance, m.
    """
    if len(cells) < LEAST_CELLS or contact.is_level:
        return None, 0.0
    aside = _aside(cells, contact.radius)
    askew = float(np.hypot(*aside)) * contact.radius
    if askew < max(by_chance, (1.0 if contact.flat else NOT_FLAT) * ASKEW):
        return None, 0.0
    face = _fitted(cells, contact.radius, aside)
    if face is None or not contact.is_of(face) or abs(contact.height.value - face.height) > MOST_APART * askew:
        return None, askew - ASKEW
    return face, 0.0


def _aside(cells: Array, radius: float) -> Array:
    """Return the slopes (2,) of the plane through a ring of heights (n, 3), m, around a contact with a radius, m: it rises to a face's side."""
    away = np.hypot(cells[:, 0], cells[:, 1])
    ring = cells[(away > RING[0] * radius) & (away < RING[1] * radius)]
    if len(ring) < LEAST_CELLS // 2:
        return np.zeros(2)
    a = np.column_stack([np.ones(len(ring)), ring[:, :2]])
    return np.asarray(np.linalg.lstsq(a, ring[:, 2], rcond=None)[0][1:])


def _fitted(cells: Array, radius: float, aside: Array) -> Face | None:
    """Return the face fitted to heights (n, 3), m, around a contact with a radius, m, looked for to one side (2,); None where no fit is found."""
    cells, aside = np.ascontiguousarray(cells.T), aside / float(np.hypot(*aside))
    widths = [math.log(min(max(wide * radius, NARROWEST), WIDEST)) for _, wide, _ in STARTS]
    starts = [
        np.array([*(far * radius * aside), wide, wide, turn])
        for (far, _, turn), wide in zip(STARTS, widths, strict=True)
    ]
    try:
        begun = sorted((_Fit(cells, start).run(FIRST_ROUNDS) for start in starts), key=lambda fit: fit.left)
        fit = min((fit.run(ROUNDS) for fit in begun[:BEST]), key=lambda fit: fit.left)
    except np.linalg.LinAlgError:
        return None
    found = Face(float(fit.c[0]), fit.c[1:3], fit.q[:2], (math.exp(fit.q[2]), math.exp(fit.q[3])), float(fit.q[4]))
    return found if math.isfinite(fit.left) else None


class _Fit:
    """Outline q (5,): middle, m, logarithms of half its width and length, and turn; c (13,) are plane and fall; `left`, m^2, the squares left."""

    def __init__(self, cells: Array, q: Array) -> None:
        self._cells, self._damping, self.q = cells, 1e-2, q
        self.c, self.left, self._rest = self._solved(q)

    def _solved(self, q: Array) -> tuple[Array, float, Array]:
        """Return plane and fall, the squares left, and the residuals (n,), m, of an outline."""
        a, z = _design(self._cells[0], self._cells[1], q), self._cells[2]
        normal = a @ a.T
        normal[np.diag_indices_from(normal)] *= 1.0 + TINY
        c = np.linalg.solve(normal, a @ z)
        rest = z - c @ a
        return c, float(rest @ rest), rest

    def run(self, rounds: int) -> Self:
        """Take so many rounds, or fewer until it has settled."""
        for _ in range(rounds):
            before = self.left
            if not self._moved() or before - self.left < SETTLED * self.left:
                break
        return self

    def _moved(self) -> bool:
        """Take a step that leaves less, if there is one."""
        slopes = np.stack([(self._solved(self.q + step)[2] - self._rest) / step.sum() for step in STEPS])
        normal, right = slopes @ slopes.T, -slopes @ self._rest
        for _ in range(DAMPINGS):
            damped = normal + self._damping * np.diag(np.diag(normal) + TINY * normal.max())
            q = _held(self.q + np.linalg.solve(damped, right))
            c, left, rest = self._solved(q)
            if left < self.left:
                self.q, self.c, self.left, self._rest = q, c, left, rest
                self._damping *= 0.3
                return True
            self._damping *= 4.0
        return False


def _held(q: Array) -> Array:
    """Return an outline that is neither too far nor too wide."""
    far = math.hypot(q[0], q[1])
    if far > FARTHEST:
        q[:2] *= FARTHEST / far
    q[2:4] = np.clip(q[2:4], math.log(NARROWEST), math.log(WIDEST))
    return q


def _design(x: Array, y: Array, q: Array) -> Array:
    """Return the plane and the parts of the fall (13, n) at places (n,)."""
    a, b = math.exp(q[2]), math.exp(q[3])
    cos, sin = math.cos(q[4]), math.sin(q[4])
    x, y = x - q[0], y - q[1]
    u, v = (cos * x + sin * y) / a, (cos * y - sin * x) / b
    u2, v2 = u * u, v * v
    r = (u2 * u2 + v2 * v2) ** (1.0 / POWER)
    away = np.maximum(np.hypot(x, y), 1e-9)
    d = away * (1.0 - 1.0 / np.maximum(r, 1e-9))
    d = 0.5 * (d + np.sqrt(d * d + EDGE**2))
    size = math.sqrt(a * b)
    i, j = x / away, y / away
    parts = np.stack([np.ones_like(x), i, j, i * i - j * j, 2.0 * i * j])
    return np.concatenate([[parts[0], x, y], size * np.log1p(d / size) * parts, d * d / size * parts])


def _cells(points: FloatArray, valid: MaskArray, middle: Array, reach: float) -> Array:
    """Return the means (n, 3), m, of squares of pixels around a place (2,), m, of which most are valid."""
    near = valid & (np.hypot(points[..., 0] - middle[0], points[..., 1] - middle[1]) < reach)
    rows, columns = (np.flatnonzero(near.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return np.empty((0, 3))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    side = math.ceil(math.sqrt(np.count_nonzero(near) / MOST_CELLS))
    points, near = points[box], near[box]
    h, w = (n // side for n in near.shape)
    near = near[: h * side, : w * side].reshape(h, side, w, side)
    points = points[: h * side, : w * side].reshape(h, side, w, side, 3)
    count = near.sum(axis=(1, 3))
    mean = np.where(near[..., None], points, 0.0).sum(axis=(1, 3)) / np.maximum(count, 1)[..., None]
    return np.asarray(mean[count > 0.6 * side * side], dtype=np.float64)
