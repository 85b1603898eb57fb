"""The text of a cell file whose devices are reached at stand-ins."""

import json

HEAD = "format: stretch-cell/1\ndevices:\n"
_OWN = "the stand-in's own"
_COUNTS = {"points": [{"count": 3, "opening": "140 mm"}, {"count": 230, "opening": "0 mm"}], "source": _OWN}
DEVICES = {
    "arm": {
        "type": "Arm",
        "use": "ur",
        "model": "ur5",
        "base": {"x": "-500 mm"},
        "hand": {"z": "300 mm", "rx": "180 deg"},
        "source": _OWN,
    },
    "gripper": {"type": "Gripper", "use": "robotiq", "model": "2f140", "calibration": _COUNTS},
    "force_sensor": {
        "type": "ForceSensor",
        "use": "ati",
        "calibration": {"counts_per_newton": 1000000, "counts_per_newton_metre": 1000000, "source": _OWN},
    },
    "camera": {"type": "DepthCamera", "use": "realsense"},
}


def lab_cell(host, devices):
    """Return a cell file's text: `devices` has the wanted devices by name, each with the options that differ from DEVICES."""
    lines = (f"  {name}: {json.dumps({**DEVICES[name], 'host': host, **own})}\n" for name, own in devices.items())
    return HEAD + "".join(lines)
