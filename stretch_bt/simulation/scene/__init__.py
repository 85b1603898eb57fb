"""Scene files, which say what the twin simulates."""

from stretch_bt.simulation.scene.file import (
    Scene,
    load_scene,
    parse_scene,
    scene_names,
    scene_schema,
    scene_text,
)

__all__ = ["Scene", "load_scene", "parse_scene", "scene_names", "scene_schema", "scene_text"]
