"""Hard cases of the map of presses: what moved, stands apart, goes on to a clamp, hangs over, or is not there."""

import importlib.util
from pathlib import Path

import numpy as np

from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.perception.clouds.coverage import coverage, hidden
from stretch_bt.perception.clouds.next_view import next_view
from stretch_bt.perception.clouds.relief import add_view

_spec = importlib.util.spec_from_file_location("sheets", Path(__file__).parent.parent / "clouds" / "sheets.py")
s = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(s)
MM = 1e-3
ACROSS = (0, 0, np.pi / 2)
MOVED = (IllConditioned, "the object moved or gave way")


def after(**moved):
    """Return a call that adds a press of a box that is no more as it was."""
    return lambda: add_view(s.pressed(lambda x, y: s.box(x, y, **moved), yaw=0.1), s.mapped(s.box, (0, 0, 0), ACROSS))


def pair(x, y):
    left, right = (s.dome(x, y, (9 * MM,) * 2, 15 * MM, (at, 0.0)) for at in (-20 * MM, 20 * MM))
    return np.maximum(left, right)


def long(x, y):
    return s.box(x, y, half=(20 * MM, 70 * MM)) - 0.5 * MM


def nothing(x, y):
    return 0.0 * x


def carved_only(relief):
    assert (relief.felt_area, coverage(relief), relief.summit, relief.pieces) == (0.0, 0.0, None, 0)


def clear_of_the_clamps(relief):
    assert np.abs(relief.place(np.argwhere(relief.felt))[:, 1]).max() < 45 * MM


def only_its_upper_side(relief):
    """Of a plate on a stem the stem is neither felt nor looked for."""
    assert np.abs(relief.height[relief.felt] - 30 * MM).max() < 3 * MM
    assert hidden(relief).height[hidden(relief).cells].min(initial=1.0) > 20 * MM


CASES = {
    "the object sank by 3 mm": (after(top=27 * MM), MOVED),
    "the object rose by 3 mm": (after(top=33 * MM), MOVED),
    "the object went 9 mm across": (after(at=(9 * MM, 0.0)), MOVED),
    "the object went 9 mm along": (after(at=(0.0, -9 * MM)), MOVED),
    "another, smaller object": (after(half=(12 * MM, 12 * MM)), MOVED),
    "the object stayed": (lambda: after()().views, 3),
    "two objects": (lambda: s.mapped(pair, (0, 0, 0), ACROSS, height=4 * MM).pieces, 2),
    "contact at the clamp is told": (lambda: s.pressed(long, height=26 * MM).cut, True),
    "contact short of the clamps": (lambda: s.pressed(s.box).cut, False),
    "contact at the clamp is not believed": (lambda: add_view(s.pressed(long, height=26 * MM)), clear_of_the_clamps),
    "an overhang": (lambda: s.mapped(s.box, (0, 0, 0), ACROSS), only_its_upper_side),
    "no contact": (lambda: s.mapped(nothing, (0, 0, 0)), carved_only),
    "no contact to plan from": (
        lambda: next_view(s.mapped(nothing, (0, 0, 0)), depth=10 * MM, length=100 * MM, width=90 * MM),
        (NoContact, "nothing was felt yet"),
    ),
    "no place in reach": (
        lambda: next_view(
            s.mapped(s.box, (0, 0, 0)), depth=10 * MM, length=100 * MM, width=90 * MM, x=(0.4, 0.5), y=(0.4, 0.5)
        ),
        None,
    ),
}
