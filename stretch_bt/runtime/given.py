"""Devices that the caller of `run` gave, in the place of a cell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stretch_bt.hardware.interfaces import Device

__all__ = ["Given"]


class Given:
    """Devices that the caller gave, and keeps."""

    def __init__(self, devices: Mapping[str, Device]) -> None:
        self.devices = devices

    def truth(self) -> dict[str, float]:
        """Nothing is known."""
        return {}

    def sketch(self) -> dict[str, list[tuple[float, float]]]:
        """Nothing is known."""
        return {}

    def stats(self) -> list[dict[str, Any]]:
        """Nothing is simulated."""
        return []

    def stop(self) -> list[Exception]:
        """Stop every device."""
        errors: list[Exception] = []
        for device in self.devices.values():
            try:
                device.stop()
            except Exception as error:  # one that breaks must not keep the others moving
                errors.append(error)
        return errors

    def close(self) -> list[Exception]:
        """Leave them open."""
        return []
