"""Devices that the caller of `run` gave, in the place of a cell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from stretch_bt.hardware.interfaces import Device
from stretch_bt.hardware.journal import Journal

__all__ = ["Given"]


@runtime_checkable
class Telling(Protocol):
    """A device that tells a run of the commands it gets, as those of a cell do; a scripted one is."""

    def tell(self, name: str, journal: Journal) -> None:
        """Tell the journal from now on; `name` is what the tree calls the device."""
        ...


class Given:
    """Devices that the caller gave, and keeps."""

    def __init__(self, devices: Mapping[str, Device]) -> None:
        self.devices = devices

    def tell(self, journal: Journal) -> None:
        """Let a journal take note of what nodes command."""
        for name, device in self.devices.items():
            if isinstance(device, Telling):
                device.tell(name, journal)

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
