"""What is no array, frame or contact at all: each public function refuses each of its arguments, or gives an answer."""

import inspect
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stretch_bt import perception
from stretch_bt.accuracy.perception.noise import WHITE_05, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import InvalidInput, NoAnswer, StretchError
from stretch_bt.frames import Pose
from stretch_bt.perception.types import INVALID
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.units import Estimate

ODD = {
    "None": None,
    "text": "10mm",
    "a number": 7,
    "a fraction": 7.5,
    "a truth": True,
    "NaN": np.nan,
    "below 0": -1.0,
    "a list of nothing": [],
    "a list of None": [None],
    "rows of different lengths": [[0, 0, 0], [1, 2]],
    "a mapping": {},
    "objects": np.array([[None, "x"], [1, 2]], dtype=object),
    "no number": np.array(3.0),
    "one axis": np.ones(7),
    "two axes": np.ones((7, 9)),
    "three axes": np.ones((7, 9, 3), np.float32),
    "two axes of bytes": np.ones((7, 9), np.uint8),
    "truths": np.ones((7, 9), bool),
    "rows of three": np.ones((7, 3)),
    "four axes": np.ones((2, 7, 9, 3)),
    "complex": np.ones((7, 3), complex),
    "words": np.array(["a", "b"]),
    "masked": np.ma.masked_array(np.ones((7, 3)), mask=True),
    "an estimate": Estimate(1.0, 0.1),
    "another object": object(),
}
RESULTS = {  # what functions return, or hold what a node writes: nobody makes one by hand
    "Candidate", "Cap", "Cloud", "Cone", "Contact", "ContactSize", "Curvatures", "Cylinder", "Diameters", "Dimension", "Dimensions",
    "FrameNoise", "MountedMembrane", "Outline", "Pattern", "PixelNoise", "Plane", "Roundness", "Segmentation", "Shape", "Solid", "Sphere",
}  # fmt: skip
METHODS = {
    "Contact.from_heights": perception.Contact.from_heights,
    "DepthFrame.from_array": perception.DepthFrame.from_array,
    "ContactDetector.update": lambda depth: perception.ContactDetector().update(depth),
    "HeightTracker.update": lambda depth: perception.HeightTracker().update(depth),
    "FreeView.add": lambda frame: perception.FreeView().add(frame),
    "Pose.at_height": perception.Pose().at_height,
    "Pose.moved": perception.Pose().moved,
}
CALLS = {name: getattr(perception, name) for name in perception.__all__ if name not in RESULTS} | METHODS


@pytest.fixture(scope="module")
def given():
    """Return right arguments by name, and arguments by name for single functions, which come before the others."""
    frame = observe(seen(BodyPress(Sphere(0.02), stretch=0.03, depth=0.01)), WHITE_05, seed=1)
    frame = replace(frame, pose=Pose((0.0, 0.0, 0.1)), hand_height=0.1)
    contact = perception.find_contact(frame)
    sphere = perception.fit_sphere(contact.points)
    cloud = perception.fuse_contact(contact)
    cap = perception.cap_of(contact, 0.01)
    free = perception.FreeView()
    free.add(frame)
    rays = perception.view_rays(contact.points, (0.0, 0.0, 0.2))
    strain = Estimate(0.3, 0.05)
    membrane = perception.mounted_membrane(0.1, 0.09, 0.002, 0.0, 0.03, Estimate(0.0, 1e-3))
    fine = {"points": contact.points, "rays": rays, "noise": 1e-4}
    named = {
        "frame": frame, "frames": [frame] * 8, "depth": frame.depth, "intrinsics": frame.intrinsics, "contact": contact, "cloud": cloud,
        "contacts": [contact], "points": contact.surface, "surface": contact.surface, "labels": contact.labels,
        "valid": contact.labels != INVALID, "pattern": _pattern(frame), "radius": 0.01, "caps": [cap, cap], "region": contact.labels,
        "where": contact.surface, "outline": 0.01 * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), "before": sphere, "now": sphere, "gauge": 0.1,
        "width": 0.09, "stretch": 0.03, "height": 0.01, "thickness": 0.002, "strain": strain, "membrane": membrane, "prestretch": 0.0,
        "hang": Estimate(0.0, 1e-3), "curvature": None, "below": 2e-3, "plane_distance": 0.2, "along_i": np.linspace(1, 2, 60),
        "along_j": -np.linspace(10, 20, 60), "heights": contact.surface[..., 2], "pixel": 4e-4, "unit": 1e-4, "path": Path("no.png"),
        "key": "depth", "times": [0.0], "camera": (0.0, 0.0, 0.2), "raw": frame.raw, "time": 0.0, "sequence": 0, "normals": contact.surface,
        "fx": 400.0, "fy": 400.0, "cx": 10.0, "cy": 10.0, "sd": 1e-4, "area": 1.0,
    }  # fmt: skip
    own = dict.fromkeys(("fit_sphere", "fit_plane", "fit_cylinder", "fit_cone", "fit_shape", "cloud_of"), fine)
    own |= {
        "top_of_points": fine,
        "view_rays": fine,
        "Contact.from_heights": {"labels": None, "noise": 1e-4},
        "membrane_height": {"curvature": Estimate(50.0, 2.0), "depth": 0.01},
        "Intrinsics": {"width": 640, "height": 480},
        "pixel_noise": {"width": 15},
        "deproject": {"intrinsics": frame.intrinsics},
    }
    return named, own


def _pattern(frame):
    """Return a pattern such as a free membrane shows."""
    zero = np.zeros(frame.raw.shape, np.float32)
    return perception.Pattern(zero, zero, 0.0, 0.0, 1e-3, 0.0, 0.0)


def arguments(name, given):
    """Return those arguments of a call that are right; options that have no name in the table keep their defaults."""
    named, own = given
    known = named | own.get(name, {})
    parameters = inspect.signature(CALLS[name]).parameters.values()
    return {p.name: known[p.name] for p in parameters if p.default is p.empty or p.name in own.get(name, {})}


def cases():
    for name, call in CALLS.items():
        for parameter in inspect.signature(call).parameters:
            yield name, parameter


def answered(name, these):
    try:
        found = CALLS[name](**these)
        if inspect.isgenerator(found):
            list(found)
    except StretchError as error:
        assert str(error)


@pytest.mark.parametrize("name", CALLS)
def test_the_table_calls_each_function_as_it_is_meant(name, given):
    if not name.startswith("load_"):
        with suppress(NoAnswer):  # this one frame carries no answer to some
            CALLS[name](**arguments(name, given))


@pytest.mark.parametrize("name", CALLS)
def test_an_array_with_a_mask_of_its_own_is_refused_rather_than_read_below_it(name, given):
    these = arguments(name, given)
    for parameter, array in these.items():
        if isinstance(array, np.ndarray):
            for hidden in (5, 0):  # a mask that hides nothing yet is one as well
                masked = np.ma.masked_array(array, mask=np.arange(array.size).reshape(array.shape) < hidden)
                with pytest.raises(InvalidInput, match="an array without a mask, got a masked one; give "):
                    CALLS[name](**these | {parameter: masked})


@pytest.mark.parametrize(("name", "parameter"), list(cases()))
def test_an_argument_of_another_kind_is_refused_as_such(name, parameter, given):
    these = arguments(name, given)
    wrong = []
    for odd, value in ODD.items():
        try:
            answered(name, these | {parameter: value})
        except Exception as error:
            wrong.append(f"{odd}: {type(error).__name__}: {error}")
    assert not wrong, "\n".join(wrong)
