"""How far the labels of a contact reach past its border, from the curvature of the membrane across the border.

Labels are drawn where a smoothed curvature has fallen to a half, which is not where the membrane leaves the body: the kernel
widens the curved part, and a sheet that resists bending goes on bending outside, by exp(-s / l) over a length l = sqrt(D / T). Both are
modelled: a border at a shift from the labels, around a round body (curved within) or a flat one (curved along its rim), falls off over l
and is smoothed by the kernel. The mean curvature by distance from the labels is compared with the model of each shift, length and kind;
the answer is the weighted mean over all of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.curvature import bending
from stretch_bt.perception.lateral import lateral
from stretch_bt.perception.regions import filled
from stretch_bt.perception.scale import SEED, Scale, ground_of, mean_scale
from stretch_bt.perception.surface import Cleaned, Surface, binned_surface, clean
from stretch_bt.perception.tension import LEAST_PULL, expected_ratio
from stretch_bt.perception.types import CONTACT, INVALID, Contact, MaskArray
from stretch_bt.units import Estimate, Length

__all__ = ["Border", "border_of", "past_labels"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]

KERNELS = (1.9e-3, 2.7e-3, 3.8e-3)  # m, as `segment` has them
CLEAR = 10.0  # standard deviations of the curvature, from which a kernel is wide enough
SHIFTS: Array = np.arange(-6.0, 9.01, 0.5) * 1e-3  # m
LENGTHS = (0.3e-3, 0.8e-3, 1.5e-3, 2.5e-3, 4.0e-3)  # m, of a sheet of 2 mm that is pulled by 60 to 5 mm: sqrt(D / T)
INSIDE, OUTSIDE, RING = 7e-3, 8e-3, 0.4e-3  # m: how far the curvature is followed, and the width of one mean
# Bins, over the square of the kernel, of one independent value: the integral of the squared correlation of a second derivative of smoothed noise
ALONE = 4.58
# m; how much too far in the border is found on solved sheets, on all shapes and noises alike: a fillet is touched beyond the middle of
# its bend; and the standard deviation that remains without noise (`python benchmarks/outline_errors.py`)
INWARD, FORM = 0.45e-3, 0.35e-3
# How far labels reach too far, kernels, mean and deviation: half of a smoothed curvature lies 0 (straight border) to 1.2 kernels (a point) out
REACH, REACH_SD = 0.6, 0.45
BEYOND = 6e-3  # m past the labels, from where curvature belongs to another part of the contact
AS_CURVED = 0.3  # share of the curvature at the border from which such a part is as clear
ELSEWHERE = 5.0  # standard deviations at which the largest of some hundred places is curved
EDGE = 1.5e-3  # m, within which of the largest shift the border may as well lie further in
# m, loss of a perimeter at four right corners that the finest kernel rounds
CORNERS = (8.0 - 2.0 * math.pi) * KERNELS[0]
UNEVEN = 0.4  # share of a shift: how much it differs along a border across which the tensions differ
FREE = 6.0  # independent values of a mean by distance, less shift, length and size
RARE = 4.0  # squared misfit added to a cone's: most contacts are round or flat bodies
BLUR = 1.0  # pixels over which dropouts in a region are bridged


@dataclass(frozen=True, slots=True)
class Border:
    """Where the border of a contact is: `shift`, m, with its deviation, within the labels' own; curvature was smoothed by `kernel`, m."""

    shift: Estimate
    kernel: Length

    @property
    def uneven(self) -> Length:
        """Standard deviation, m, of a perimeter beside the border's place: its corners, and a shift that is not alike all around."""
        return math.hypot(CORNERS, 2.0 * math.pi * UNEVEN * self.shift.value)


@dataclass(frozen=True, slots=True)
class _Rings:
    """Means over rings around a border: which ring each bin (h, w) is in, or past the last, and how many bins each has."""

    distance: Array
    ring: npt.NDArray[np.intp]
    trusted: MaskArray
    count: Array

    @classmethod
    def of(cls, distance: Array, trusted: MaskArray) -> _Rings:
        first = max(-INSIDE, float(distance.min()))
        rings = int((OUTSIDE - first) / RING)
        if rings < 1:
            raise IllConditioned(
                "the labels lie beside the raised part of the membrane, so that they have no border on it; give the labels of this very frame"
            )
        ring = np.floor((distance - first) / RING).astype(np.intp)
        ring = np.where(trusted & (ring >= 0) & (ring < rings), ring, rings)
        return cls(distance, ring.ravel(), trusted, np.bincount(ring.ravel(), minlength=rings + 1)[:-1].astype(float))

    def means(self, image: npt.NDArray[np.floating]) -> Array:
        """Return the mean (n,) of an image (h, w) over each ring."""
        total = np.bincount(self.ring, image.ravel().astype(np.float64), minlength=len(self.count) + 1)[:-1]
        return np.asarray(total / np.maximum(self.count, 1.0))


def border_of(contact: Contact) -> Border:
    """Return how far the labels of a contact reach past its border, negative where they end inside.

    Raises
    ------
    IllConditioned
        The membrane is not pulled, so that it is curved far beyond the contact; another part of it is curved as much, so that the labels
        hold a part of the contact only; or too little of it has depth.
    """
    if contact.stretch is not None and contact.stretch < LEAST_PULL:
        raise IllConditioned(
            f"the membrane is stretched by {contact.stretch * 1e3:.1f} mm: a sheet that is not pulled is curved far beyond where it"
            f" touches, so that curvature does not show the border; give a `level`, or stretch it by {LEAST_PULL * 1e3:.0f} mm"
        )
    cleaned = clean(contact.surface, contact.labels != INVALID, 1)
    if cleaned is None:
        raise IllConditioned(
            "too little of the surface has depth to show the border; keep reflections off the membrane"
        )
    scale = _scale(cleaned, contact.stretch)
    surface = scale.ground.surface
    rings = _Rings.of(_in_bins(past_labels(contact) * cleaned.pitch, cleaned, surface), surface.trusted)
    ratio = scale.ratio or expected_ratio(contact.stretch)
    _check_whole(rings, scale)
    shifts, misfits = _misfits(rings, _curved(cleaned, scale, float(ratio.value)), scale)
    misfits += ((shifts / scale.ground.kernel - REACH) / REACH_SD) ** 2
    weights = np.exp(-0.5 * (misfits - misfits.min()))
    weights /= weights.sum()
    mean = float(weights @ shifts)
    if not SHIFTS[0] < mean < SHIFTS[-1] - EDGE:
        raise IllConditioned(
            f"the border of the contact lies {mean * 1e3:.0f} mm or more within the labels; look again, press deeper, or give a `level`"
        )
    sd = math.hypot(math.sqrt(float(weights @ (shifts - mean) ** 2)), FORM)
    return Border(Estimate(mean - INWARD, sd), scale.ground.kernel)


def _check_whole(rings: _Rings, scale: Scale) -> None:
    """Refuse labels that are a part of a contact: then the membrane is curved at a rim that lies beyond them, too."""
    signal, ground = scale.signals[0], scale.ground
    means, alone = rings.means(signal.curvature), rings.count / (ALONE * ground.surface.sigma**2)
    if float((means * np.sqrt(np.maximum(alone, 1.0))).max()) < ELSEWHERE * signal.sd:
        raise IllConditioned(
            "the membrane is not clearly curved at the border of the labels; press deeper, average more frames, or give a `level`"
        )
    beyond = (rings.distance > BEYOND) & ground.raised & rings.trusted
    there = float(signal.curvature.max(where=beyond, initial=0.0))
    if there > max(AS_CURVED * float(means.max()), ELSEWHERE * signal.sd):
        raise IllConditioned(
            f"the membrane is curved by {there:.0f} per metre over {BEYOND * 1e3:.0f} mm beyond the pixels labelled as contact, which seem to be"
            " a part of it, as the higher side of a leaning face is; press deeper, or give a `level`"
        )


def past_labels(contact: Contact) -> Array:
    """Return how far each pixel (h, w) lies outside the region that is labelled, pixels, negative inside; dropouts are bridged."""
    import cv2

    valid = contact.labels != INVALID
    cover, region = (
        cv2.GaussianBlur(mask.astype(np.float32), (0, 0), BLUR) for mask in (valid, contact.labels == CONTACT)
    )
    inside = filled(np.asarray(region >= 0.5 * np.maximum(cover, 0.1)))
    within, out = (
        cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) for mask in (inside, ~inside)
    )
    return np.where(inside, 0.5 - within, out - 0.5).astype(np.float64)


def _scale(cleaned: Cleaned, stretch: float | None) -> Scale:
    """Return a frame at the finest kernel at which its curvature is clear, or the widest."""
    fine = binned_surface(cleaned, KERNELS[0])
    for kernel in KERNELS:
        surface = fine if kernel == KERNELS[0] else binned_surface(cleaned, kernel, (fine.noise, fine.length))
        scale = mean_scale(ground_of(kernel, surface), lateral(cleaned, kernel), expected_ratio(stretch), None)
        if scale.clearness >= CLEAR:
            break
    if scale.clearness < SEED:
        raise IllConditioned(
            f"the curvature of the membrane stands out of the noise by {scale.clearness:.1f} standard deviations, and {SEED:g} show a border;"
            " press deeper, average more frames, or give a `level`"
        )
    return scale


def _in_bins(image: Array, cleaned: Cleaned, surface: Surface) -> Array:
    """Return the means of an image of the whole frame over the bins of a part of it."""
    step, (v, u), (rows, columns) = surface.step, surface.origin, surface.height.shape
    top, left = (first + step * n for first, n in zip(cleaned.corner, (v, u), strict=True))
    part = image[top : top + rows * step, left : left + columns * step]
    past = [(0, size * step - n) for size, n in zip((rows, columns), part.shape, strict=True)]
    return np.asarray(np.pad(part, past, mode="edge").reshape(rows, step, columns, step).mean(axis=(1, 3)))


def _curved(cleaned: Cleaned, scale: Scale, ratio: float) -> tuple[Image, Image, Image]:
    """Return the mean curvature (h, w), 1/m, that a round body has all over, one that peaks at the rim of a flat body, and a cone's.

    Divided by powers of the slope it is even on a sphere; the plain second derivative has its peak at a kink, the other one inside.
    """
    bent = bending(scale.ground.surface, lateral(cleaned, scale.ground.kernel))
    along = -(bent.xx + np.float32(ratio) * bent.yy) / np.float32(1.0 + ratio)
    plain = along.astype(np.float32)
    return scale.signals[0].curvature, plain, plain


def _misfits(rings: _Rings, curved: tuple[Image, Image, Image], scale: Scale) -> tuple[Array, Array]:
    """Return shifts (n,), m, and the squared misfit of each, in standard deviations, over both kinds of body and all lengths.

    The noise is the frame's, or the residual to the best of all where that is more.
    """
    surface, signal = scale.ground.surface, scale.signals[0]
    weight = rings.count / (ALONE * surface.sigma**2)
    shifts, left, rare, noises = [], [], [], []
    for kind, image in zip(_KINDS, curved, strict=True):
        seen = rings.means(image)
        peak = max(float(np.abs(seen).max()), 1e-9)
        noises.append((signal.sd / peak) ** 2)
        for shift in SHIFTS:
            past = rings.distance + shift
            if not (past < 0.0).any():
                continue
            for length in LENGTHS:
                left.append(_left(seen / peak, rings.means(_smoothed(kind(past, length), surface.sigma)), weight))
                shifts.append(shift)
                rare.append(RARE if kind is _pointed else 0.0)
    misfits = np.array(left)
    return np.array(shifts), misfits / max(float(np.mean(noises)), float(misfits.min()) / FREE) + np.array(rare)


def _round(past: Array, length: float) -> Array:
    return np.exp(-np.maximum(past, 0.0) / length)


def _flat(past: Array, length: float) -> Array:
    return np.exp(-np.abs(past) / length)


def _pointed(past: Array, length: float) -> Array:
    """Return the curvature of a cone, which grows towards its tip as one over the distance from the tip."""
    radius = max(-float(past.min()), RING)
    return np.where(past < 0.0, radius / np.maximum(radius + past, RING), np.exp(-np.maximum(past, 0.0) / length))


_KINDS = (_round, _flat, _pointed)


def _smoothed(image: Array, sigma: float) -> Image:
    import cv2

    return np.asarray(cv2.GaussianBlur(image.astype(np.float32), (0, 0), sigma))


def _left(seen: Array, model: Array, weight: Array) -> float:
    """Return the weighted squared residual to a model at its best size, which is not negative: a contact is convex."""
    size = max(float((weight * model) @ seen) / max(float((weight * model) @ model), 1e-30), 0.0)
    return float(weight @ (seen - size * model) ** 2)
