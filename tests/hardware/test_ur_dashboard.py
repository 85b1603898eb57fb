"""What the dashboard answers, line by line."""

import pytest

from stretch_bt.hardware.emulators.stage import Stage
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.dashboard import Dashboard
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn


@pytest.fixture
def dashboard(request):
    """The dashboard of a controller that nobody cycles, with its controller."""
    made = getattr(request, "param", Ur5eStandIn)("127.0.0.1", Stage())
    found = Dashboard("127.0.0.1", 0, made.controller, made.faults)
    yield lambda line: found.answer(line.encode()), made.controller
    found.server.stop()


#: what is said of a controller at rest
AT_REST = {
    "robotmode": "Robotmode: RUNNING",
    "SafetyMode": "Safetymode: NORMAL",
    "running": "Program running: false",
    "programState": "STOPPED <unnamed>",
    "get loaded program": "No program loaded",
    "isProgramSaved": "false <unnamed>",
    "load any.urp": "File not found: any.urp",
    "load installation default.installation": "File not found: default.installation",
    "play": "Failed to execute: play",
    "pause": "Failed to execute: pause",
    "stop": "Stopped",
    "popup look here": "showing popup",
    "close popup": "closing popup",
    "close safety popup": "closing safety popup",
    "addToLog hello": "Added log message",
    "unlock protective stop": "Protective stop releasing",
    "get robot model": "UR5",
    "quit": "Disconnected",
    "nonsense": 'could not understand: "nonsense"',
    "": 'could not understand: ""',
}


@pytest.mark.parametrize("dashboard", [Ur5StandIn, Ur5eStandIn], indirect=True)
@pytest.mark.parametrize("asked", AT_REST)
def test_a_controller_at_rest_answers(dashboard, asked):
    answer, _ = dashboard
    assert answer(asked) == AT_REST[asked]


#: by command, whether a CB3 has it, and whether an e-series has
ONLY = {
    "version": (False, True),
    "is in remote control": (False, True),
    "safetystatus": (False, True),
    "get operational mode": (False, True),
    "set operational mode manual": (False, True),
    "getUserRole": (True, False),
    "setUserRole operator": (True, False),
    "get serial number": (True, True),
}


@pytest.mark.parametrize("dashboard", [Ur5StandIn, Ur5eStandIn], indirect=True)
@pytest.mark.parametrize("asked", ONLY)
def test_each_generation_has_its_own_commands(dashboard, asked):
    answer, controller = dashboard
    assert (not answer(asked).startswith("could not")) is ONLY[asked][controller.profile.e_series]


def test_power_goes_off_and_on(dashboard):
    answer, _ = dashboard
    told = [
        (answer(line), answer("robotmode").split()[1])
        for line in ("power off", "power on", "brake release", "shutdown")
    ]
    assert told == [
        ("Powering off", "POWER_OFF"),
        ("Powering on", "IDLE"),
        ("Brake releasing", "RUNNING"),
        ("Shutting down", "POWER_OFF"),
    ]


def test_a_program_is_held_and_goes_on(dashboard):
    answer, controller = dashboard
    steps = []

    def program():
        while True:
            steps.append(1)
            yield

    controller.load(program(), 0.0)
    controller.cycle()
    assert answer("programState") == "PLAYING <unnamed>"
    assert answer("pause") == "Pausing program"
    assert answer("programState") == "PAUSED <unnamed>"
    done = len(steps)
    cycles(controller, 50)
    assert len(steps) == done
    assert answer("play") == "Starting program"
    cycles(controller, 2)
    assert len(steps) == done + 2
    assert answer("stop") == "Stopped"
    assert answer("programState") == "STOPPED <unnamed>"


def test_the_operational_mode_is_kept(dashboard):
    answer, _ = dashboard
    assert answer("set operational mode sideways") == "Failed setting operational mode: sideways"
    assert answer("set operational mode automatic") == "Operational mode AUTOMATIC is set"
    assert answer("get operational mode") == "AUTOMATIC"
    assert answer("clear operational mode").startswith("No longer controlling")
    assert answer("get operational mode") == "NONE"


def cycles(controller: Controller, count: int) -> None:
    for _ in range(count):
        controller.cycle()
