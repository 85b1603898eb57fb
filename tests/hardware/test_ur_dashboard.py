"""What the dashboard answers, line by line."""

import pytest

from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.dashboard import DashboardService
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn


@pytest.fixture
def dashboard(request):
    """The dashboard of a controller that nobody cycles, with its controller."""
    made = getattr(request, "param", Ur5eStandIn)("127.0.0.1", StandInWorld())
    found = DashboardService("127.0.0.1", 0, made.controller, made.faults)
    made.controller.inject = made.faults.inject
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


@pytest.mark.parametrize("lasting", ["emergency_stop", "safeguard_stop", "violation"])
@pytest.mark.parametrize("first", [True, False], ids=["before", "after"])
def test_a_stop_outlasts_a_protective_stop_that_is_unlocked_beside_it(dashboard, lasting, first):
    answer, controller = dashboard
    for state in (lasting, "protective_stop") if first else ("protective_stop", lasting):
        controller.stop_safely(state, "a test", 0.0)
    told = controller.safety
    assert told.bits & 1 << 2, "the bit of the protective stop"
    assert not told.bits & 1, "the bit of normal operation"
    for asked in ("unlock protective stop", "power on", "brake release"):
        answer(asked)
    assert controller.safety.name == told.name
    assert lasting.upper() in told.name
    assert answer("robotmode").endswith("POWER_OFF") is (lasting == "emergency_stop")
    controller.release_stop(lasting)
    assert controller.safety.name == "NORMAL"


def test_a_protective_stop_is_there_when_the_safeguard_is_closed(dashboard):
    answer, controller = dashboard
    controller.stop_safely("protective_stop", "a test", 0.0)
    controller.stop_safely("safeguard_stop", "a test", 0.0)
    controller.release_stop("safeguard_stop")
    assert answer("safetymode") == "Safetymode: PROTECTIVE_STOP"


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


ORDERS = [
    *("load any.urp", "play", "stop", "pause", "shutdown", "power on", "power off", "brake release"),
    *("unlock protective stop", "close safety popup", "load installation any", "restart safety"),
    *("set operational mode manual", "clear operational mode", "POWER OFF"),
]


@pytest.mark.parametrize("dashboard", [Ur5StandIn, Ur5eStandIn], indirect=True)
def test_out_of_remote_control_an_e_series_answers_and_obeys_nothing(dashboard):
    answer, controller = dashboard
    controller.inject("local")
    controller.stop_safely("protective_stop", "a test", 0.0)
    refused = [order for order in ORDERS if "switch robot to Remote Control" in answer(order)]
    assert refused == (ORDERS if controller.profile.e_series else [])
    assert (controller.safety.name == "PROTECTIVE_STOP", controller.powered) == (controller.profile.e_series,) * 2
    assert answer("programState") == "STOPPED <unnamed>"
    assert answer("popup look here") == "showing popup"


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
