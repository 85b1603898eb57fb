"""Contacts of membranes over shapes, from closed forms of their own, with noise."""

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.perception import fuse_contact
from stretch_bt.perception.types import Contact

MM = 1e-3
PIXEL = 0.42 * MM
FILLET = 1 * MM
PLACES = ((0.0, 0.0), (0.012, 0.0), (0.0, -0.012))
FALL = 0.5  # slope of a skirt


def bend(u, length):
    """Straight to either side of 0, its slope passing from 0 to 1 over a length."""
    return np.maximum(u, 0.0) + length / 2 * np.exp(-np.abs(u) / length)


def inset(fall=FALL):
    """How far inside the side of a block the straight parts of a membrane meet that leaves its fillet."""
    return FILLET * (1 - np.tan(np.arctan(fall) / 2))


#: further inside where it leaves the fillet no steeper than that
GENTLE = 0.25 * MM * (1 - FALL / 0.75)


def turned(x, y, heading):
    c, s = np.cos(heading), np.sin(heading)
    return c * x + s * y, c * y - s * x


def block(length, width, height, heading=0.0):
    def z(x, y):
        x, y = turned(x, y, heading)
        out = np.stack([np.abs(x) - length / 2 + inset() + GENTLE, np.abs(y) - width / 2 + inset() + GENTLE])
        away = np.hypot(*np.maximum(out, 0.0)) + np.minimum(out.max(axis=0), 0.0)
        return height - FALL * bend(away, 0.3 * MM)

    return z


def rounded(length, width, corner, height, heading=0.0):
    def z(x, y):
        x, y = turned(x, y, heading)
        out = np.stack([np.abs(x) - length / 2, np.abs(y) - width / 2]) + corner
        away = np.hypot(*np.maximum(out, 0.0)) + np.minimum(out.max(axis=0), 0.0) - corner
        return height - FALL * bend(away, 0.3 * MM)

    return z


def prism(corners, height):
    """An upright prism over a convex outline through corners (n, 2), counter-clockwise."""
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    along = sides / lengths[:, None]
    normals = np.column_stack([along[:, 1], -along[:, 0]])

    def z(x, y):
        out = np.full(x.shape, -np.inf)
        near = np.full(x.shape, np.inf)
        for corner, t, n, length in zip(corners, along, normals, lengths, strict=True):
            dx, dy = x - corner[0], y - corner[1]
            out = np.maximum(out, dx * n[0] + dy * n[1])
            on = np.clip(dx * t[0] + dy * t[1], 0.0, length)
            near = np.minimum(near, np.hypot(dx - on * t[0], dy - on * t[1]))
        away = np.where(out > 0, near, out)
        return height - FALL * bend(away + inset() + GENTLE, 0.3 * MM)

    return z


def disc(diameter, height):
    return lambda x, y: height - FALL * bend(np.hypot(x, y) - diameter / 2 + inset() + GENTLE, 0.3 * MM)


def crest(length, height, across, heading, more):
    """A membrane over a crest whose cross-section is `across`, which ends `more` beyond the rule for an edge."""

    def z(x, y):
        x, y = turned(x, y, heading)
        return height + across(np.abs(y)) - FALL * bend(np.abs(x) - length / 2 + inset() + 2 * GENTLE + more, 1.2 * MM)

    return z


def ridge(length, height, heading=0.0):
    layer, fall = 2.35 * MM, 0.2
    return crest(length, height, lambda u: fall * layer - fall * (u + layer * np.exp(-u / layer)), heading, 0.45 * MM)


def half_cylinder(length, radius, heading=0.0):
    layer, touch = 2.35 * MM, 4 * MM
    u = np.arange(0.0, 0.1, 0.02 * MM)
    slope = np.tan(np.arcsin(np.minimum(u, touch) / radius))
    curvature = np.where(u < touch, 0.0, np.exp(-(u - touch) / layer) / radius)
    fall = np.cumsum(slope + np.cumsum(curvature) * 0.02 * MM) * 0.02 * MM
    return crest(length, radius, lambda v: -np.interp(v, u, fall), heading, -0.35 * MM)


def domes(places):
    """Half-spheres (x, radius) on the table, with the membrane straight from where it leaves each."""

    def z(x, y):
        found = []
        for at, radius in places:
            away = np.hypot(x - at, y)
            leaves = 0.42 * radius
            root = np.sqrt(radius**2 - leaves**2)
            cap = np.sqrt(np.maximum(radius**2 - away**2, root**2))
            found.append(np.where(away < leaves, cap, root - leaves / root * (away - leaves)))
        return np.max(found, axis=0)

    def touched(x, y):
        return np.any([np.hypot(x - at, y) < 0.42 * radius for at, radius in places], axis=0)

    z.touched = touched
    return z


def raised(body, by):
    """A body with its membrane `by` higher above the table."""

    def z(x, y):
        return body(x, y) + by

    z.touched = body.touched
    return z


def point(height):
    return lambda x, y: height - 0.6 * (np.hypot(np.hypot(x, y), 0.8 * MM) - 0.8 * MM)


def over_wire(away, top, near, far, length=2.4 * MM):
    """The membrane by the distance from the middle of a wire of 1 mm radius whose top is at `top`."""
    change, lean = near - far, -(near + far) / 2
    above = change * length / 2
    u = away - (above + 1 * MM) * lean
    return top + above + near * u - change * bend(u, length)


def wire_circle(diameter, top):
    return lambda x, y: over_wire(np.hypot(x, y) - diameter / 2 + 1 * MM, top, 0.03, -0.5)


def wire_triangle(side, top, heading=0.3):
    def z(x, y):
        normals = heading + np.arange(3) * 2 * np.pi / 3
        away = np.max([np.cos(a) * x + np.sin(a) * y for a in normals], axis=0) - side / (2 * np.sqrt(3))
        return over_wire(away, top, 0.03, -0.4)

    return z


def contact(height, place, depth, rng, noise, top):
    """The contact of a hand over a place, whose flat membrane is `depth` below the top."""
    v, u = np.mgrid[-110:111, -105:106] * PIXEL
    x, y = place[0] + u, place[1] - v  # the membrane frame is left-handed
    z = np.maximum(height(x, y), top - depth) + noise * rng.normal(size=x.shape)
    surface = np.stack([u, v, z - (top - depth)], axis=2)
    on = height.touched(x, y) if hasattr(height, "touched") else surface[..., 2] > depth - 1.5 * MM
    labels = np.where(on, 2, 1).astype(np.uint8)
    points = surface[labels == 2]
    rays = points - [0.0, 0.0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    pose = Pose((*place, top - depth))
    return Contact(points, rays, labels, noise, top - depth, 0.0, 0.0, surface, np.ones(labels.shape), pose)


def felt(height, top, noise=0.05 * MM, seed=0, depth=10 * MM, places=PLACES):
    """Return a cloud and the contacts that it was fused from."""
    rng = np.random.default_rng(seed)
    contacts = [contact(height, place, depth, rng, noise, top) for place in places]
    cloud = None
    for one in contacts:
        cloud = fuse_contact(one, cloud)
    return cloud, contacts
