"""pyrealsense2, imported where it is used, and its USB library found."""

from __future__ import annotations

import ctypes
from importlib.util import find_spec
from typing import Any

__all__ = ["INSTALL", "library"]

INSTALL = "pip install 'stretch-bt[realsense]', or 'stretch-bt[sr305]' for an SR300 or SR305"


def library() -> Any:
    """Return the module; raises ImportError that says what to install."""
    try:
        try:
            import pyrealsense2
        except ImportError as error:
            if "libusb" not in str(error) or find_spec("libusb_package") is None:
                raise
            import libusb_package

            ctypes.CDLL(str(libusb_package.get_library_path()), mode=ctypes.RTLD_GLOBAL)  # for machines without libusb
            import pyrealsense2
    except (ImportError, OSError) as error:  # a library of the wheel that cannot be loaded, too
        raise ImportError(f"{error}; install it with: {INSTALL}") from error
    return pyrealsense2
