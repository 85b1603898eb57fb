"""`emulate` and `activate` as a person gives them."""

import io
import json
import sys

import pytest

from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld

CELL = """\
format: stretch-cell/1
devices:
  gripper:
    type: Gripper
    use: robotiq_urcap
    host: 127.0.0.1
    port: PORT
    model: 2f140
    calibration: {points: [{count: 3, opening: 140 mm}, {count: 230, opening: 0 mm}], source: the stand-in's own}
"""


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["arm"], "there is no stand-in 'arm'; there are"),
        (["ati", "--host", "here"], "no address to listen on"),
        (["ati", "--port", "rtu=1"], "the wires are commands, page, rdt"),
        (["ati", "--port", "rdt=x"], "write rdt=54321"),
        (["ati", "--scene", "nowhere"], "nowhere"),
        (["ati", "ati"], "name each stand-in once"),
        (["ati", "--control", "70000"], "65535"),
    ],
)
def test_what_emulate_refuses(cli, options, said):
    code, out, err = cli("emulate", *options)
    assert (code, out) == (2, "")
    assert said in err


@pytest.fixture
def gripper(tmp_path):
    """A gripper that is not activated, and a cell file for it."""
    ports = {"urcap": dict.fromkeys(stand_in_class("urcap").PORTS, 0)}
    with serving(["urcap"], StandInWorld(), ports=ports) as servers:
        port = servers.served.wires["urcap"]["urcap"].partition(":")[2]
        (tmp_path / "lab.yaml").write_text(CELL.replace("PORT", port))
        yield servers.stand_ins["urcap"]


def test_activate_asks_and_moves_the_fingers_only_then(cli, gripper, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO("n\n"))
    code, _, err = cli("activate", "lab.yaml")
    assert code == 1
    assert "travel all their way" in err
    assert gripper.state() == {"opening": 0.055, "writes": 0, "moving": False, "fault": 0}
    code, out, err = cli("activate", "lab.yaml", "--yes", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out) == {"device": "gripper", "state": "done", "opening": pytest.approx(0.14)}


def test_an_activation_that_fails_is_a_fault(cli, gripper):
    gripper.inject("object", {"opening": 0.03})
    code, _, err = cli("activate", "lab.yaml", "--yes")
    assert code == 3
    assert "fault 0D: the activation failed; take away what is in the way" in err


def test_what_activate_refuses(cli, tmp_path):
    code, _, err = cli("activate", "simulated", "--yes")
    assert (code, "needs no activation" in err) == (2, True)
    (tmp_path / "none.yaml").write_text("format: stretch-cell/1\ndevices: {arm: {type: Arm, use: simulated}}\n")
    code, _, err = cli("activate", "none.yaml", "--yes")
    assert (code, "none.yaml has no gripper" in err) == (2, True)
