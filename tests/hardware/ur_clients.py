"""Programs for a process of their own: the real clients of a UR controller at an address, each reported as one line of JSON.

The clients hold the interpreter while they connect, so that they cannot share one with a stand-in.
"""

import json
import math
import os
import sys
import time

TOOL = [0.0, 0.0, 0.3, math.pi, 0.0, 0.0]


def apart(one, other):
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


def until(ask, seconds=10.0):
    end = time.monotonic() + seconds
    while not ask():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


def control(host, upper=True):
    from rtde_control import RTDEControlInterface as Control

    flags = Control.FLAG_UPLOAD_SCRIPT | (Control.FLAG_UPPER_RANGE_REGISTERS if upper else 0)
    return Control(host, -1.0, flags)


def tour(host):
    """Use every command that a stand-in plays, and say how far each was off."""
    from dashboard_client import DashboardClient
    from rtde_io import RTDEIOInterface
    from rtde_receive import RTDEReceiveInterface

    found = {}
    receive = RTDEReceiveInterface(host)
    c = control(host)
    io = RTDEIOInterface(host)
    found["set tcp"] = c.setTcp(TOOL) and apart(c.getTCPOffset(), TOOL)
    until(lambda: abs(receive.getActualTCPPose()[2] - 0.2) < 1e-6)
    place, q = receive.getActualTCPPose(), receive.getActualQ()
    turned = [q[0] + 0.1, *q[1:]]
    aside = [place[0] + 0.02, *place[1:]]
    low = [*place[:2], place[2] - 0.02, *place[3:]]

    def joints_off(there):
        until(lambda: apart(receive.getActualQ(), there) < 1e-9, 1.0)
        return apart(receive.getActualQ(), there)

    def off(there):
        until(lambda: apart(receive.getActualTCPPose()[:3], there[:3]) < 1e-9, 1.0)
        return apart(receive.getActualTCPPose()[:3], there[:3])

    found["moveJ"] = c.moveJ(turned, 1.0, 4.0) and joints_off(turned)
    found["moveJ_IK"] = c.moveJ_IK(place, 1.0, 4.0) and off(place)
    found["moveL_FK"] = c.moveL_FK(turned, 0.5, 2.0) and joints_off(turned)
    found["moveL"] = c.moveL(place, 0.5, 2.0) and off(place)
    legs = [[*low, 0.2, 2.0, 0.0], [*aside, 0.2, 2.0, 0.0]]
    found["moveL path"] = c.moveL(legs, False) and off(aside)
    started = c.moveL([place[0] - 0.2, *place[1:]], 0.1, 1.0, True)
    found["running"] = until(lambda: c.getAsyncOperationProgressEx().isAsyncOperationRunning())
    until(lambda: receive.getActualTCPPose()[0] < aside[0] - 0.005)
    c.stopL(2.0)
    stopped = receive.getActualTCPPose()
    time.sleep(0.05)
    found["stopL"] = started and off(stopped)
    found["over"] = until(lambda: not c.getAsyncOperationProgressEx().isAsyncOperationRunning())
    c.moveL(place, 0.5, 2.0)
    c.speedL([0, 0, -0.05, 0, 0, 0], 1.0, 0.1)
    found["speedL"] = until(lambda: abs(receive.getActualTCPSpeed()[2] + 0.05) < 1e-3)
    found["speedStop"] = c.speedStop(5.0) and until(lambda: apart(receive.getActualTCPSpeed(), [0.0] * 6) < 1e-6)
    c.speedJ([0.1, 0, 0, 0, 0, 0], 1.0, 0.1)
    found["speedJ"] = until(lambda: abs(receive.getActualQd()[0] - 0.1) < 1e-3) and c.speedStop(5.0)
    c.moveL(place, 0.5, 2.0)
    c.servoL(low, 0, 0, 0.008, 0.05, 300)
    found["servoL"] = until(lambda: off(low) < 1e-5) and c.servoStop() and off(low)
    c.moveL(place, 0.5, 2.0)
    found["inverse"] = apart(c.getInverseKinematics(place, receive.getActualQ()), receive.getActualQ())
    found["has solution"] = c.getInverseKinematicsHasSolution(place)
    found["has none"] = not c.getInverseKinematicsHasSolution([2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    found["forward"] = apart(c.getForwardKinematics(receive.getActualQ(), TOOL), receive.getActualTCPPose())
    found["steady"] = until(c.isSteady)
    found["zeroFtSensor"] = c.zeroFtSensor()
    io.setStandardDigitalOut(1, True)
    io.setSpeedSlider(0.5)
    found["io"] = until(lambda: receive.getActualDigitalOutputBits() == 2 and receive.getSpeedScaling() == 0.5)
    try:
        control(host)
    except RuntimeError as error:
        found["second client"] = str(error)
    found["watchdog"] = c.setWatchdog(20.0) and until(lambda: not c.isProgramRunning())
    found["without a program"] = not c.moveL(low, 0.1, 0.5)
    dashboard = DashboardClient(host)
    dashboard.connect(2000)
    found["dashboard"] = [dashboard.robotmode(), dashboard.safetymode(), dashboard.polyscopeVersion()]
    found["again"] = c.reuploadScript() and until(c.isProgramRunning) and c.moveL(place, 0.5, 2.0) and off(place)
    io.disconnect()
    c.stopScript()
    found["stopped"] = until(lambda: not dashboard.running())
    return found


def contact(host):
    """Ask the controller to move until it feels something."""
    c = control(host, upper=False)
    return {"done": c.moveUntilContact([0, 0, -0.05, 0, 0, 0])}


def custom(host):
    """Run a program of one's own between two of the client's."""
    from rtde_receive import RTDEReceiveInterface

    receive, c = RTDEReceiveInterface(host), control(host)
    q = receive.getActualQ()
    turned = [q[0] + 0.2, *q[1:]]
    lines = [f"movej({turned}, t=0.4)", "write_output_integer_register(24, 2)"]
    found = {"done": c.sendCustomScript("\n".join(["def own():", *lines, "end", ""]))}
    found["there"] = until(lambda: apart(receive.getActualQ(), turned) < 1e-9)
    found["again"] = c.reuploadScript() and until(c.isProgramRunning) and c.moveJ(q, 1.0, 4.0)
    found["back"] = until(lambda: apart(receive.getActualQ(), q) < 1e-9)
    return found


def lock(host):
    """Make a protective stop, and try to unlock it at once."""
    from dashboard_client import DashboardClient
    from rtde_receive import RTDEReceiveInterface

    receive, c, dashboard = RTDEReceiveInterface(host), control(host), DashboardClient(host)
    dashboard.connect(2000)
    found = {"triggered": c.triggerProtectiveStop(), "stopped": until(receive.isProtectiveStopped)}
    try:
        dashboard.unlockProtectiveStop()
    except RuntimeError as error:
        found["too soon"] = str(error)
    return found


if __name__ == "__main__":
    sys.stdout.write(json.dumps(globals()[sys.argv[1]](sys.argv[2])) + "\n")
    sys.stdout.flush()
    os._exit(0)  # without the destructors, which wait half a second each
