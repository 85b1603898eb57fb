"""Connected parts of masks, and their shapes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.types import MaskArray

__all__ = [
    "border",
    "bounds",
    "closed",
    "distance",
    "filled",
    "hull",
    "inner_half",
    "opened",
    "parts",
    "placed",
    "touching",
    "valid_box",
    "widened",
    "with_rim",
]

Image = npt.NDArray[np.float32]
Box = tuple[slice, slice]


def parts(mask: MaskArray, seeds: MaskArray) -> Iterator[tuple[Box, MaskArray]]:
    """Yield each 8-connected part of a mask that holds a seed: its box of rows and columns, and the part there."""
    import cv2

    seeds = seeds & mask
    if not seeds.any():
        return
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8))
    for k in set(labels[seeds].tolist()):
        u, v, w, h = stats[k, :4].tolist()
        box = slice(v, v + h), slice(u, u + w)
        yield box, labels[box] == k


def placed(part: MaskArray, box: Box, window: Box, shape: tuple[int, int]) -> MaskArray:
    """Return a part, given in a box of an image of some shape, in a window of that image that holds the box."""
    (top, bottom, _), (left, right, _) = (s.indices(n) for s, n in zip(window, shape, strict=True))
    mask = np.zeros((bottom - top, right - left), dtype=bool)
    v, u = box[0].start - top, box[1].start - left
    mask[v : v + part.shape[0], u : u + part.shape[1]] = part
    return mask


def touching(mask: MaskArray, part: MaskArray) -> MaskArray:
    """Return the connected parts of a mask that share a pixel with `part`, their holes filled."""
    import cv2

    count, labels = cv2.connectedComponents(mask.view(np.uint8))
    hit = np.zeros(count, dtype=np.uint8)
    hit[labels[part & mask]] = 1
    return filled(hit[labels])


def filled(mask: npt.NDArray[np.uint8] | MaskArray) -> MaskArray:
    """Return a mask with its holes."""
    import cv2

    outline, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    whole = cv2.drawContours(np.zeros(mask.shape, dtype=np.uint8), outline, -1, 1, cv2.FILLED)
    return np.asarray(whole).view(np.bool_)


def hull(mask: MaskArray) -> MaskArray:
    """Return the convex hull of a mask."""
    import cv2

    outlines, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    whole = np.zeros(mask.shape, dtype=np.uint8)
    if outlines:
        cv2.fillConvexPoly(whole, cv2.convexHull(np.concatenate(outlines)), 1)
    return whole.view(np.bool_)


def distance(mask: MaskArray) -> Image:
    """Return how far each pixel of a mask is from its outside, pixels; the image is surrounded by outside."""
    import cv2

    padded = cv2.copyMakeBorder(mask.view(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0.0)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1], dtype=np.float32)


def inner_half(mask: MaskArray) -> MaskArray:
    """Return the inner part of a mask, half as wide as the mask."""
    depth = distance(mask)
    return np.asarray(depth > 0.5 * depth.max())


def widened(mask: MaskArray, pixels: float) -> MaskArray:
    """Return a mask widened by some pixels along both axes."""
    import cv2

    if not mask.any():
        return mask
    outside = cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, 3)
    return np.asarray(outside <= pixels)


def opened(mask: MaskArray) -> MaskArray:
    """Return the part of a mask that lies in squares of three by three of its pixels."""
    import cv2

    return np.asarray(cv2.morphologyEx(mask.view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), dtype=np.uint8)) > 0)


def closed(mask: MaskArray, wide: int) -> MaskArray:
    """Return a mask with its holes and gaps that squares of `wide` pixels along a side do not fit into."""
    import cv2

    return np.asarray(cv2.morphologyEx(mask.view(np.uint8), cv2.MORPH_CLOSE, np.ones((wide, wide), dtype=np.uint8)) > 0)


def border(mask: MaskArray) -> tuple[MaskArray, MaskArray]:
    """Return the part of a mask that does not meet its outside, and the mask with the pixels that meet it."""
    import cv2

    square = np.ones((3, 3), dtype=np.uint8)
    return np.asarray(cv2.erode(mask.view(np.uint8), square)).view(np.bool_), with_rim(mask)


def with_rim(mask: MaskArray) -> MaskArray:
    """Return a mask with the pixels that meet it."""
    import cv2

    return np.asarray(cv2.dilate(mask.view(np.uint8), np.ones((3, 3), dtype=np.uint8))).view(np.bool_)


def bounds(mask: MaskArray, margin: int, share: float = 0.0, corner: tuple[int, int] = (0, 0)) -> Box:
    """Return the rows and columns of the box around a mask with a margin and a share of its width, within the image.

    `corner` is the row and column of the mask's first pixel in the image.
    """
    import cv2

    u, v, w, h = cv2.boundingRect(mask.view(np.uint8))
    margin += int(share * max(w, h))
    v, u = v + corner[0], u + corner[1]
    return slice(max(v - margin, 0), v + h + margin), slice(max(u - margin, 0), u + w + margin)


def valid_box(valid: MaskArray) -> Box:
    """Return the rows and columns that hold the valid pixels; empty where there are none."""
    rows, columns = np.flatnonzero(valid.any(axis=1)), np.flatnonzero(valid.any(axis=0))
    if not rows.size:
        return slice(0, 0), slice(0, 0)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
