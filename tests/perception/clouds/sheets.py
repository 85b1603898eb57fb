"""Sheets hung over known heights, as two looks of a press show them."""

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.perception.clouds.expected import drape
from stretch_bt.perception.clouds.relief import add_view
from stretch_bt.perception.clouds.seen import view_of

MM = 1e-3
STEP = 1.25 * MM
U = (np.arange(72) + 0.5) * STEP - 45 * MM
V = (np.arange(80) + 0.5) * STEP - 50 * MM


def box(x, y, half=(20 * MM, 20 * MM), top=30 * MM, at=(0.0, 0.0)):
    return np.where((np.abs(x - at[0]) < half[0]) & (np.abs(y - at[1]) < half[1]), top, 0.0)


def dome(x, y, radii=(25 * MM, 20 * MM), top=20 * MM, at=(0.0, 0.0)):
    return top * np.sqrt(np.maximum(1 - ((x - at[0]) / radii[0]) ** 2 - ((y - at[1]) / radii[1]) ** 2, 0.0))


def surface(ground, x, y, yaw, height):
    """Return a sheet over a ground, in the membrane frame, whose y runs against the hand's."""
    c, s = np.cos(yaw), np.sin(yaw)
    u, v = U[:, None], V[None, :]
    sheet = drape(ground(x + c * u - s * v, y + s * u + c * v)[None], np.array([height]))[0]
    sheet, u, v = _finer(sheet), _finer(u + 0 * v), _finer(v + 0 * u)
    shape = sheet.shape
    return np.stack([np.broadcast_to(u, shape), np.broadcast_to(-v, shape), sheet - height], axis=2)


def _finer(values):
    """Return values halfway between the rows and the columns as well."""
    for axis in (0, 1):
        first, last = (
            np.take(values, range(*span), axis) for span in ((0, values.shape[axis] - 1), (1, values.shape[axis]))
        )
        both = np.stack([first, (first + last) / 2], axis=axis + 1)
        values = both.reshape([-1 if k == axis else n for k, n in enumerate(first.shape)])
    return values


def pressed(ground, x=0.0, y=0.0, yaw=0.0, height=15 * MM, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    poses = [Pose((x, y, h), (0.0, 0.0, yaw)) for h in (height, height + 2 * MM)]
    deep, shallow = (
        surface(ground, x, y, yaw, p.height) + [0, 0, 1] * rng.normal(0, 1, (142, 158, 1)) * noise for p in poses
    )
    return view_of(deep, shallow, deep_pose=poses[0], shallow_pose=poses[1], half_length=50 * MM)


def mapped(ground, *poses, **options):
    relief = None
    for pose in poses:
        relief = add_view(pressed(ground, *pose, **options), relief)
    return relief
