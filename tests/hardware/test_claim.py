"""One program has a device at a time: claims, the events that free them, and refusals."""

import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress

import pytest

from stretch_bt.errors import DeviceLost, NotReady
from stretch_bt.hardware import examine
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.claim import Claim, claims_folder
from stretch_bt.hardware.examine import halt
from stretch_bt.hardware.implementations import driver_class
from stretch_bt.hardware.robotiq.gripper import RobotiqGripper

PLACE = "the gripper at 127.0.0.1 port 1"
#: takes a place and says so, and ends with its input
HOLDER = """
import sys
from stretch_bt.hardware.claim import Claim
with Claim("other", sys.argv[1]):
    print("has it", flush=True)
    sys.stdin.read()
"""
NETWORK = ("robotiq-rtu", "urcap")
GRIPPERS = (*NETWORK, "robotiq-serial")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder for claims of this test alone."""
    runtime = tmp_path / "user"
    runtime.mkdir()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime))
    return claims_folder()


@pytest.fixture
def holder():
    """Begin another program that has a place."""
    begun = []

    def begin(place):
        process = subprocess.Popen(
            [sys.executable, "-c", HOLDER, place], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        begun.append(process)
        assert process.stdout.readline().strip() == "has it"
        return process

    yield begin
    for process in begun:
        process.kill()
        process.communicate()


def test_a_place_that_another_program_has_is_refused_until_its_end(holder):
    process = holder(PLACE)
    with pytest.raises(NotReady, match=f"mine: {PLACE} is not to be had: process {process.pid} has it; .*kill -INT"):
        Claim("mine", PLACE).take()
    Claim("mine", "the gripper at 127.0.0.1 port 2").take()
    process.communicate()
    Claim("mine", PLACE).take()


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_a_holder_that_is_killed_frees_its_place(holder, end):
    process = holder(PLACE)
    process.send_signal(end)
    process.wait()
    with Claim("mine", PLACE):
        pass


def test_a_holder_that_is_stopped_keeps_its_place(holder):
    process = holder(PLACE)
    process.send_signal(signal.SIGSTOP)
    with pytest.raises(NotReady, match=str(process.pid)):
        Claim("mine", PLACE).take()


def test_one_program_has_a_place_once_and_lets_go_of_it():
    with Claim("a", PLACE) as first:
        first.take()
        with pytest.raises(NotReady, match="this program has it open already"):
            Claim("b", PLACE).take()
    first.release()
    with Claim("b", PLACE), Claim("c", None), Claim("d", None):
        pass
    assert list(claims_folder().iterdir()) == []


def test_many_who_take_a_place_in_turn_have_it_one_at_a_time():
    """A file that its holder takes away is nobody's claim."""
    inside, most = [], []

    def take_often():
        had = 0
        while had < 100:
            with suppress(NotReady), Claim("a", PLACE):
                inside.append(1)
                most.append(len(inside))
                inside.pop()
                had += 1

    threads = [threading.Thread(target=take_often) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(most) == {1}


def test_a_device_that_does_not_open_is_let_go(live_cell, clock):
    for _ in range(2):
        with pytest.raises(DeviceLost, match="does not answer"):
            open_cell(load_cell(live_cell("robotiq", "rtu", "127.0.0.1:9")), now=clock)


def test_a_process_that_was_forked_meanwhile_keeps_no_place():
    asked, told = os.pipe()
    with Claim("a", PLACE):
        child = os.fork()
        if child == 0:
            os.close(told)
            os.read(asked, 1)
            os._exit(0)
    try:
        with Claim("b", PLACE):
            pass
    finally:
        os.close(asked)
        os.close(told)
        os.waitpid(child, 0)


def test_the_folder_is_of_its_user_alone(folder):
    with Claim("a", "the arm at ../../x"):
        assert folder.stat().st_mode & 0o777 == 0o700
        (file,) = folder.iterdir()
        assert file.stat().st_mode & 0o777 == 0o600
        assert file.read_text() == f"{os.getpid()}\n"


def linked(folder, elsewhere):
    folder.symlink_to(elsewhere)


def open_to_all(folder, elsewhere):
    folder.mkdir()
    folder.chmod(0o777)


def a_file(folder, elsewhere):
    folder.write_text("")


def a_linked_file(folder, elsewhere):
    folder.mkdir(mode=0o700)
    (folder / f"{PLACE}.lock").symlink_to(elsewhere / "target")


@pytest.mark.parametrize("harm", [linked, open_to_all, a_file, a_linked_file])
def test_a_folder_that_is_not_our_own_is_refused(tmp_path, folder, harm):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    harm(folder, elsewhere)
    with pytest.raises(NotReady, match=r"a: .* cannot be kept in .*stretch-bt.*(remove it|chmod 700)"):
        Claim("a", PLACE).take()
    assert list(elsewhere.iterdir()) == []


def test_without_a_folder_of_the_user_there_is_one_in_the_temporary_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "gone"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert claims_folder() == tmp_path / f"stretch-bt-{os.getuid()}"


# (type, implementation, its place, what is claimed; none where more than one program may have it)
PLACES = [
    ("Arm", "ur", {"host": "10.0.0.1", "model": "ur5", "base": {}, "hand": {}}, "the arm at 10.0.0.1"),
    ("Gripper", "robotiq", {"host": "10.0.0.1", "port": 7}, "the gripper at 10.0.0.1 port 7 unit 9"),
    ("Gripper", "robotiq", {"serial": "LINK"}, "the gripper on LINE"),
    ("Gripper", "robotiq", {"serial": "LINE"}, "the gripper on LINE"),
    ("Gripper", "robotiq_urcap", {"host": "10.0.0.1"}, "the gripper at 10.0.0.1 port 63352"),
    ("DepthCamera", "realsense", {"serial": "1234"}, "the camera 1234"),
    ("DepthCamera", "realsense", {"host": "10.0.0.1"}, None),
    ("ForceSensor", "ati", {"host": "10.0.0.1"}, "the force sensor at 10.0.0.1 port 49152"),
    ("Gripper", "simulated", {}, None),
]


@pytest.mark.parametrize(("kind", "use", "options", "claimed"), PLACES)
def test_what_a_device_claims(tmp_path, kind, use, options, claimed):
    line, link = tmp_path / "line", tmp_path / "link"
    line.touch()
    link.symlink_to(line)
    cls = driver_class(kind, use)
    named = {k: str(tmp_path / v.lower()) if v in ("LINE", "LINK") else v for k, v in options.items()}
    found = cls("device", cls.Options.model_construct(**named), None).claimed()
    assert found == (claimed and claimed.replace("LINE", str(line)))


def test_an_arm_that_another_program_has_is_not_begun(make_cell, clock):
    first = make_cell("ur")
    with pytest.raises(NotReady, match=r"arm: the arm at .* is not to be had"):
        open_cell(first.spec, now=clock)
    assert first.devices["arm"].state == "ready"


@pytest.mark.parametrize("kind", NETWORK)
def test_a_halt_from_outside_holds_fingers_that_a_run_moves(make_cell, clock, kind):
    cell = make_cell(kind)
    cell.devices["gripper"].move(0.080, speed=0.050, owner="a")
    clock.time += 0.1
    (found,) = halt(cell.spec)
    assert found.ok
    clock.time += 1.0
    assert not cell.stand_in.state()["moving"]
    assert cell.stand_in.state()["opening"] < 0.075


def test_a_halt_cannot_have_a_serial_line_beside_a_run_and_names_who_has_it(make_cell, monkeypatch):
    cell = make_cell("robotiq-serial")
    monkeypatch.setattr(examine, "_LETTING_GO", 0.0)
    (found,) = halt(cell.spec)
    assert not found.ok
    assert "press the emergency stop" in found.fix
    assert "the gripper on /dev/pts/" in found.fix
    assert "this program has it open already" in found.fix


def test_a_halt_has_a_serial_line_as_soon_as_a_run_lets_go_of_it(make_cell, monkeypatch):
    cell, opened = make_cell("robotiq-serial"), []

    def wire(driver):
        if opened:
            cell.close()
        opened.append(driver)
        return made(driver)

    made = RobotiqGripper._wire
    monkeypatch.setattr(RobotiqGripper, "_wire", wire)
    (found,) = halt(cell.spec)
    assert found.ok, found
    assert len(opened) == 2


@pytest.mark.parametrize("kind", GRIPPERS)
def test_a_second_cell_with_the_gripper_is_refused_and_stops_nothing(make_cell, clock, advance, kind):
    first = make_cell(kind)
    motion = first.devices["gripper"].move(0.080, speed=0.050, owner="a")
    clock.time += 0.1
    with pytest.raises(NotReady, match=r"gripper: the gripper (at|on) .* is not to be had: this program has it"):
        open_cell(first.spec, now=clock)
    assert first.stand_in.state()["moving"]
    assert advance(motion) == "done"
    first.close()
    open_cell(first.spec, now=clock).close()


@pytest.mark.parametrize("kind", GRIPPERS)
def test_who_never_moved_the_fingers_writes_nothing_and_who_halts_them_does(make_cell, kind):
    cell = make_cell(kind)
    before = cell.stand_in.state()["writes"]
    cell.devices["gripper"].opening(max_age=5.0)
    cell.stop()
    assert cell.stand_in.state()["writes"] == before
    cell.devices["gripper"].driver.hold()
    assert cell.stand_in.state()["writes"] == before + 1
    cell.close()
    assert cell.stand_in.state()["writes"] == before + 1
