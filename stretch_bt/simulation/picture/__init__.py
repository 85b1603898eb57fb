"""Pictures of a scene, as SVG or PNG."""

from stretch_bt.simulation.picture.scene import draw_scene, save_scene
from stretch_bt.simulation.picture.stage import Stage

__all__ = ["Stage", "draw_scene", "save_scene"]
