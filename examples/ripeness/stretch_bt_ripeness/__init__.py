"""The node of the task `ripeness.yaml`."""

from stretch_bt_ripeness.crown_height import CrownHeight

__all__ = ["CrownHeight"]
