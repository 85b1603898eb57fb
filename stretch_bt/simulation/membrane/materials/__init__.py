"""Materials of the membrane, one file each."""

from stretch_bt.simulation.membrane.materials.base import Material
from stretch_bt.simulation.membrane.materials.mooney_rivlin import MooneyRivlin
from stretch_bt.simulation.membrane.materials.neo_hookean import NeoHookean
from stretch_bt.simulation.membrane.materials.rubber import rubber

__all__ = ["Material", "MooneyRivlin", "NeoHookean", "rubber"]
