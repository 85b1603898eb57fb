"""A camera that sees what a hand somewhere else would see: pictures of a twin, taken once and kept, as a driver and behind the wire of a real one."""

import tempfile
from contextlib import contextmanager
from pathlib import Path

from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.emulators.realsense import RealsenseStandIn
from stretch_bt.hardware.emulators.registry import STAND_INS
from stretch_bt.hardware.hand import Hand, HandGeometry
from stretch_bt.hardware.implementations import SHIPPED
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.simulated.camera import SimulatedCamera, _Options
from stretch_bt.hardware.simulated.twin import Twin
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.sensor import Shot
from stretch_bt.simulation.scene import load_scene

#: an object so high that the hand of the stand-in is soon there
SCENE = """\
format: stretch-scene/1
fidelity: hertz
effects: {white_noise: on}
object: {type: sphere, diameter: 20 mm, rigid: true, base: 175 mm}
conditions: {stretch: 0 mm, depth: 8 mm, hold: 1 s, speed: 0 mm/s, frames: 8, presses: 15, travel: 0 mm}
"""
#: pictures of one pose that differ by their noise
ALIKE = 16


class Album(SimulatedCamera):
    """Sees a twin of its own, pressed as deep as the hand of the stand-in is low; each picture is taken once, to a quarter of a millimetre."""

    class Options(_Options):
        use: str

    simulated = False
    #: where the hand is
    hand = staticmethod(lambda: Pose((0.0, 0.0, 0.19)))
    _twin, _pictures = None, {}

    def __init__(self, name, options, cell):
        seen = type(cell)(cell.now, 0, cell.root, cell.hand, cell.limits)
        seen.__dict__["twin"] = type(self)._twin = type(self)._twin or twin()
        super().__init__(name, options, seen)

    def _expose(self, number):
        pose, time_ = type(self).hand(), number / self.options.rate
        key = round(4e3 * pose.height) / 4e3, number % ALIKE
        if key not in self._pictures:
            there = pose.at_height(key[0])
            exposure = self._sensor.expose(Shot(time_, key[1], there, 0.0, self._twin.world.contact(there, 0.0)))
            self._pictures[key] = counts(exposure), exposure.unit
        raw, unit = self._pictures[key]
        frame = DepthFrame(raw, unit, self.intrinsics, time_, number, plane_distance=HandGeometry().plane_distance)
        return Reading(frame, time_, time_, number)


class AlbumStandIn(RealsenseStandIn):
    """Sends those pictures to librealsense."""

    def __init__(self, host, stage, ports=None):
        super().__init__(host, stage, ports)
        self._view = AlbumView(album(stage.now, 30))


class AlbumView:
    """An album as the stand-in asks for it."""

    late = 0

    def __init__(self, album):
        self._album = album

    def frame(self, number):
        return self._album._expose(number).value


def album(now, rate):
    """Return a camera that is asked directly."""
    options = Album.Options(type="DepthCamera", use="album", rate=f"{rate} Hz")
    return Album("camera", options, CellContext(now, 0, Path(), Hand(), Limits()))


def twin():
    """The twin that is looked at; nothing moves in it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "high.yaml"
        path.write_text(SCENE)
        return Twin(load_scene(path), HandGeometry(), lambda: 0.0, 0)


@contextmanager
def enlisted():
    """Let cell files name this camera, and `serving` its stand-in, until the context is left."""
    SHIPPED["DepthCamera", "album"] = f"{__name__}:Album"
    STAND_INS["album"] = f"{__name__}:AlbumStandIn"
    yield
    del SHIPPED["DepthCamera", "album"], STAND_INS["album"]
