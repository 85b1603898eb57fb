"""A look at a camera from outside: whether it is connected, or the recording or the stand-in is there."""

from __future__ import annotations

import json
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.isolated import environment, interpreter
from stretch_bt.hardware.realsense.library import library
from stretch_bt.hardware.realsense.options import RealsenseOptions

__all__ = ["look"]

_WITHIN = 10.0
_ASK = "from stretch_bt.hardware.realsense.look import connected; connected()"


def look(name: str, options: RealsenseOptions, root: Path) -> Iterator[Finding]:
    """Yield whether frames can come from where the options say."""
    check = f"{name}: source"
    if options.serial is not None:
        yield _camera(check, options.serial)
    elif options.file is not None:
        there = (root / options.file).is_file()
        yield Finding(check, there, options.file, "" if there else "write a path relative to the cell file")
    else:
        assert options.host is not None
        yield _stand_in(check, options.host, options.port)


def connected() -> None:
    """Print what cameras the library sees, as JSON."""
    rs = library()
    wanted = (rs.camera_info.name, rs.camera_info.firmware_version, rs.camera_info.usb_type_descriptor)
    found = {
        d.get_info(rs.camera_info.serial_number): [d.get_info(w) for w in wanted if d.supports(w)]
        for d in rs.context().query_devices()
    }
    print(json.dumps(found))  # noqa: T201  to who asked


def _camera(check: str, serial: str) -> Finding:
    """Ask in a process of its own, because the library may hang."""
    try:
        command = [*interpreter(), "-c", _ASK]
        asked = subprocess.run(command, capture_output=True, timeout=_WITHIN, check=True, env=environment())  # noqa: S603
        found = json.loads(asked.stdout)
    except subprocess.TimeoutExpired:
        return Finding(
            check, False, f"librealsense did not answer within {_WITHIN:g} s", "unplug the camera, and plug it in again"
        )
    except (subprocess.CalledProcessError, ValueError) as error:
        said = getattr(error, "stderr", b"").decode("utf-8", "replace").strip().splitlines()
        return Finding(check, False, said[-1] if said else str(error), "see what it says")
    if serial in found:
        return Finding(check, True, "; ".join(found[serial]))
    listed = "; ".join(f"{number} ({', '.join(about)})" for number, about in found.items()) or "none"
    fix = "check its cable and a USB 3 port, and the rules of udev; or correct `serial`. An SR305 needs the extra sr305"
    return Finding(check, False, f"no camera {serial}; connected: {listed}", fix)


def _stand_in(check: str, host: str, port: int) -> Finding:
    try:
        socket.create_connection((host, port), timeout=2.0).close()
    except OSError as error:
        return Finding(check, False, f"no answer at {host} port {port} ({error})", "begin stretch-bt emulate realsense")
    return Finding(check, True, f"{host} port {port} answers")
