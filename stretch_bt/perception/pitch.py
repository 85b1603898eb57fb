"""How far the points of neighbouring pixels lie apart, and whether by as much along both axes."""

from __future__ import annotations

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["check_pitch", "check_square", "pitch_of"]

SMALLEST_PITCH = 2e-6  # m; a camera 1 mm away has more
LARGEST_PITCH = 0.02  # m from pixel to pixel
SQUARE = 0.02  # share by which a pixel may be wider than high; depth cameras stay within 0.01
ALONG_SIDE = 24  # pixels along each side of an image that show whether pixels are square
LEAST = 9  # of these
OFF = 1e-3  # of the products, rms, that rays of a camera leave; single precision leaves a thousandth of it
FLAT = 1e-4  # least singular value over the largest, below which points on one line leave the answer free


def check_pitch(pitch: float) -> None:
    """Raise InvalidInput unless the distance of pixels, m, may be a camera's before a membrane."""
    if not SMALLEST_PITCH <= pitch <= LARGEST_PITCH:
        raise InvalidInput(
            f"points are in metres; {pitch:.3g} m from pixel to pixel is another unit, a wrong focal length, or noise alone"
        )


def pitch_of(points: FloatArray, valid: MaskArray, axis: int = 0) -> float:
    """Return the median distance, m, between neighbours in a row (axis 0, x) or in a column (1, y); 0 where no two valid pixels touch."""
    place, good = points[..., axis], valid
    if axis == 1:
        place, good = place.T, good.T
    for every in (max(1, valid.size // 4000), 1):
        x, seen = place[::every], good[::every]
        near = seen[:, 1:] & seen[:, :-1]
        steps = np.abs(x[:, 1:][near] - x[:, :-1][near])
        if steps.size:
            return quantile(steps)
    return 0.0


def check_square(points: FloatArray, valid: MaskArray, pitch: float) -> None:
    """Raise InvalidInput unless pixels, `pitch` m wide, are as high as wide within 2 %.

    Points that were turned after they were seen, or lie on a line, do not show it, and are taken.
    """
    ratio = _width_over_height(points, valid)
    if ratio is not None and abs(ratio - 1.0) > SQUARE:
        raise InvalidInput(
            f"pixels are square within {SQUARE:.0%}, as a depth camera's are; these lie {1e3 * pitch:.3g} mm apart along rows and"
            f" {1e3 * pitch / ratio:.3g} mm along columns: resample the depth image to square pixels, fx = fy, or look at fx and fy"
        )


def _width_over_height(points: FloatArray, valid: MaskArray) -> float | None:
    """Return the width of a pixel over its height, None where the points leave it free, or are in no frame of a camera that looks along z.

    Along the ray of a pixel (u, v), x (v - cy) = ratio y (u - cx), however deep the point lies, and so it is where all rays are parallel.
    """
    h, w = valid.shape
    for step in ((max(1, h // ALONG_SIDE), max(1, w // ALONG_SIDE)), (1, 1)):
        part = np.s_[:: step[0], :: step[1]]
        seen = valid[part] & np.isfinite(points[part]).all(axis=2)
        v, u = np.nonzero(seen)
        if len(v) >= LEAST:
            break
    else:
        return None
    x, y = points[part][seen][:, :2].astype(np.float64).T
    v, u = ((n - n.mean()) * s for n, s in zip((v, u), step, strict=True))
    design = np.stack([y * u, x, y], axis=1)
    design_scale = np.sqrt(np.mean(design**2, axis=0))
    if not design_scale.all():
        return None
    wanted = x * v
    found, _, _, singular = np.linalg.lstsq(design / design_scale, wanted)
    left = wanted - design / design_scale @ found
    if singular[-1] < FLAT * singular[0] or float(left @ left) > OFF**2 * float(wanted @ wanted):
        return None
    return abs(float(found[0] / design_scale[0]))
