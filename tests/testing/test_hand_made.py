"""Contacts and frames that are made by hand: every registered node that takes one takes these, without further ado."""

import inspect
import math

import numpy as np
import pytest

from stretch_bt import perception
from stretch_bt.perception import Contact, DepthFrame, Intrinsics, Pose, fuse_contact
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.port import Role
from stretch_bt.tree.registry import load_all

PIXEL, DISTANCE, NOISE = 0.5e-3, 0.15, 0.05e-3
RADIUS, SIDE = 0.02, 181
CAMERA = Intrinsics(DISTANCE / PIXEL, DISTANCE / PIXEL, (SIDE - 1) / 2, (SIDE - 1) / 2, SIDE, SIDE)


def surface(away: np.ndarray, rim: float = 0.008) -> np.ndarray:
    """Return how high it is without noise, m, so far from the middle, m."""
    flat = math.sqrt(RADIUS**2 - rim**2)
    cap = np.sqrt(RADIUS**2 - np.minimum(away, rim) ** 2) - flat
    return cap + rim**2 / flat * np.log(0.044 / np.clip(away, rim, 0.044))


def heights(rim: float = 0.008) -> np.ndarray:
    """Return a membrane over a sphere that it touches out to a rim, and from there on a skirt down to the frame, with noise."""
    y, x = np.mgrid[:SIDE, :SIDE] * PIXEL - (SIDE - 1) / 2 * PIXEL
    return surface(np.hypot(x, y), rim) + np.random.default_rng(0).normal(0.0, NOISE, x.shape)


def contact(rim: float = 0.008, height: float = 0.03) -> Contact:
    return Contact.from_heights(heights(rim), PIXEL, noise=NOISE, pose=Pose((0.0, 0.0, height)))


def frame(rim: float = 0.008, height: float = 0.03) -> DepthFrame:
    pose = Pose((0.0, 0.0, height))
    return DepthFrame.from_array(DISTANCE - heights(rim), CAMERA, unit=1e-5, pose=pose)


def shallow() -> DepthFrame:
    """Return a press of the same object from a little higher, with less of it in contact."""
    risen = float(np.quantile(heights(0.008), 0.999) - np.quantile(heights(0.005), 0.999))
    return frame(0.005, 0.03 + risen)


#: what nodes ask for besides, by port or by type
OTHERS = {
    "Contact": contact,
    "DepthFrame": frame,
    "list[Contact]": lambda: [contact(), contact()],
    "shallow": shallow,
    "Cloud": lambda: fuse_contact(contact()),
    "Pattern": lambda: Pattern(*np.zeros((2, SIDE, SIDE), np.float32), NOISE, 0.0, 1e-4, 0.0, 0.0),
    "height": lambda: 0.04,
    "radius": lambda: RADIUS,
}
#: ports that may be left out, and take a contact or frame all the same
BESIDE = {"track_height": ("contact",)}
TAKING = {
    info.name: info
    for info in load_all().values()
    for name, type_ in info.types.items()
    if (type_.item or type_).cls in (Contact, DepthFrame) and info.ports[name].role in (Role.INPUT, Role.INOUT)
}


def test_many_nodes_take_them():
    assert {"fit_sphere", "measure_contact", "track_height", "fuse_contact", "segment_contact"} <= TAKING.keys()


@pytest.mark.parametrize("name", TAKING)
def test_every_node_takes_them(name, tick_node, scripted_device):
    info, inputs = TAKING[name], {}
    for port in info.ports.values():
        type_ = info.types[port.name].name
        if port.role is Role.DEVICE:
            inputs[port.name] = scripted_device(type_)
        elif port.required or port.name in BESIDE.get(name, ()):
            inputs[port.name] = OTHERS[port.name if port.name in OTHERS else type_]()
    result = tick_node(name, **inputs)
    assert (result.status, result.reason) == ("SUCCESS", "")


def test_a_scripted_camera_gives_them(tick_node, scripted_device):
    camera = scripted_device("DepthCamera", {"frame": [frame(0.007), frame()]})
    result = tick_node("capture", camera=camera)
    assert (result.status, result.reason) == ("SUCCESS", "")
    assert tick_node("segment_contact", frame=result.frame).status == "SUCCESS"


def _taking(function) -> list[inspect.Parameter]:
    """Return the parameters without defaults of a function if one of them is annotated as a contact or a frame, else none."""
    needed = [p for p in inspect.signature(function).parameters.values() if p.default is p.empty]
    told = [str(p.annotation) for p in needed]
    return needed if any("DepthFrame" in text or "Contact" in text for text in told) else []


FUNCTIONS = [
    name
    for name in perception.__all__
    if inspect.isfunction(getattr(perception, name)) and _taking(getattr(perception, name))
]
#: what functions ask for, by parameter
ARGUMENTS = {
    "contact": contact,
    "contacts": lambda: [contact(), contact()],
    "frame": frame,
    "depth": frame,
    "frames": lambda: [frame() for _ in range(8)],
    "gauge": lambda: SIDE * PIXEL,
    "width": lambda: SIDE * PIXEL,
    "stretch": lambda: 0.0,
    "pattern": OTHERS["Pattern"],
    "radius": OTHERS["radius"],
    "cloud": OTHERS["Cloud"],
}


def test_many_functions_take_them():
    assert {"find_contact", "fit_contact_sphere", "fuse_contact", "deproject", "average_frames"} <= set(FUNCTIONS)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_of_perception_takes_them(name):
    function = getattr(perception, name)
    named = {p.name: ARGUMENTS[p.name]() for p in _taking(function)}
    ahead = [named.pop(p.name) for p in _taking(function) if p.kind is not p.KEYWORD_ONLY]
    assert function(*ahead, **named) is not None


@pytest.mark.parametrize("make", [perception.ContactDetector, perception.HeightTracker])
def test_what_follows_frames_takes_them(make):
    follower = make()
    assert [follower.update(frame()) for _ in range(12)]


def test_what_is_measured_is_what_was_made(tick_node):
    sphere = tick_node("fit_sphere", contact=contact()).sphere
    assert abs(sphere.radius - RADIUS) < 4 * sphere.radius_sd
    assert sphere.radius_sd < 0.05 * RADIUS
    found = tick_node("segment_contact", frame=frame()).contact
    assert (found.labels == 2).sum() * PIXEL**2 == pytest.approx(math.pi * 0.008**2, rel=0.1)
    top = tick_node("track_height", frame=frame(), contact=found)
    highest = 0.03 + float(surface(np.zeros(1))[0])
    assert abs(top.height - highest) < 4 * top.height.sd
