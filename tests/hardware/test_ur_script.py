"""URScript that clients send: what it does, and the messages for a program that cannot be read or cannot go on."""

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ur_wires import Wire, messages

from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.fields import OUTPUT_FIELDS
from stretch_bt.hardware.emulators.ur.primary_messages import robot_state
from stretch_bt.hardware.emulators.ur.programs import Programs
from stretch_bt.hardware.emulators.ur.realtime_packet import realtime_packet
from stretch_bt.hardware.emulators.ur.stand_in import Ur5StandIn
from stretch_bt.hardware.emulators.ur.urscript.parse import parse
from stretch_bt.hardware.emulators.ur.urscript.tokens import ScriptFault
from stretch_bt.hardware.emulators.ur.variables import OUTPUTS
from stretch_bt.hardware.emulators.ur.wire import pack


class Bench:
    """A controller that is cycled by hand, and what it says on its primary port."""

    def __init__(self):
        made = Ur5StandIn("127.0.0.1", StandInWorld())
        self.controller, self.said = made.controller, []
        self.programs = Programs(made.controller, lambda message: self.said.append(message(made.controller)))

    def run(self, text, seconds=20.0):
        """Send a program, and cycle until it has ended; return the cycles that it took."""
        self.programs.load(text)
        for cycle in range(round(seconds * 125)):
            self.controller.cycle()
            if cycle > 10 and not self.controller.running and self.controller.arm.steady:
                return cycle
        raise AssertionError(f"it has not ended in {seconds} s")

    def texts(self, kind):
        """Return what was said in messages of a kind."""
        return [said[15:].decode("latin-1") for said in self.said if said[14] == kind]

    def faults(self):
        """Return line and text of each exception."""
        return [(struct.unpack_from(">i", said, 15)[0], said[23:].decode()) for said in self.said if said[14] == 10]


@pytest.fixture
def bench():
    """A controller."""
    return Bench()


def function(body):
    """Return a program with these lines."""
    return "def program():\n" + body + "\nend\n"


#: an expression, and its value
EXPRESSIONS = {
    "1 + 2 * 3 - 4 / 2": "5",
    "-2 * -(3 - 1)": "4",
    "7 % 4": "3",
    "not 1 > 2 and True": "True",
    "1 == 1 xor 2 != 2": "True",
    "d2r(180)": "3.14159",
    "[1, 2, [3]][2][0]": "3",
    "length([1, 2, 3])": "3",
    "pose_trans(p[1,0,0,0,0,0], p[0,2,0,0,0,0])": "p[1, 2, 0, 0, 0, 0]",
    "pose_inv(p[1,0,0,0,0,0])[0]": "-1",
    "norm([3, 4])": "5",
    'str_cat("a#", 1)': "a#1",
    "0x10": "16",
    ".5e1": "5",
}


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_an_expression_has_its_value(bench, expression):
    bench.run(function(f"  textmsg(to_str({expression}))"))
    assert bench.faults() == []
    assert bench.texts(0) == [EXPRESSIONS[expression]]


#: lines, and what they say
LINES = {
    "loop": (
        "i = 0\nwhile i < 5:\n i = i + 1\n if i == 2:\n continue\n elif i == 4:\n break\n end\n textmsg(i)\nend",
        "13",
    ),
    "function": ("def f(a, b=2):\n return a * b\nend\ntextmsg(f(3))\ntextmsg(f(3, b=5))", "615"),
    "globals": ("global x = 1\ndef f():\n x = x + 1\n local y = 5\nend\nf()\nf()\ntextmsg(x)", "3"),
    "copies": ("a = [1, 2]\nb = a\nb[0] = 9\ntextmsg(a[0])", "1"),
    "threads": (
        "global n = 0\nthread t():\n while n < 3:\n n = n + 1\n sync()\n end\nend\nh = run t()\njoin h\ntextmsg(n)\nh = run t()\nkill h",
        "3",
    ),
    "over lines": ("x = [1,\n 2]\ntextmsg(x[1])", "2"),
    "halt": ("textmsg(1)\nhalt\ntextmsg(2)", "1"),
    "short cut": ("if False and 1 / 0 > 1:\n textmsg(1)\nelse:\n textmsg(2)\nend", "2"),
}


@pytest.mark.parametrize("lines", LINES.values(), ids=LINES)
def test_lines_say(bench, lines):
    bench.run(function(lines[0]))
    assert bench.faults() == []
    assert "".join(bench.texts(0)) == lines[1]


def test_a_program_is_told_of_from_begin_to_end(bench):
    bench.run(function("  sleep(0.5)"))
    titles = [text[9:].replace("program", "") for text in bench.texts(7)]
    assert titles == ["PROGRAM_XXX_STARTED", "PROGRAM_XXX_STOPPED"]


#: a move, the cycles of 8 ms that it takes, and where it ends: joint or axis, and how far
MOVES = {
    "movej([q[0]+0.5,q[1],q[2],q[3],q[4],q[5]], a=2, v=0.5)": (156, "joint", 0, 0.5),
    "movej([q[0]-0.5,q[1],q[2],q[3],q[4],q[5]], t=2)": (250, "joint", 0, -0.5),
    "movel(pose_add(here, p[0,0,0.05,0,0,0]), a=0.5, v=0.1)": (87, "axis", 2, 0.05),
    "movel(pose_trans(here, p[0,0,0.05,0,0,0]), t=1.0)": (125, "axis", 2, -0.05),
    "movej(pose_add(here, p[0.03,0,0,0,0,0]))": (None, "axis", 0, 0.03),
    "speedl([0,0,0.02,0,0,0], 0.5, 1.0)": (125, "axis", 2, 0.0196),
    "speedj([0.1,0,0,0,0,0], 1.0, 1.0)": (125, "joint", 0, 0.0955),
    "servoj([q[0]+0.01,q[1],q[2],q[3],q[4],q[5]], t=1.0)": (125, "joint", 0, 0.01),
    "movel(pose_trans(here, p[0,0,0.01,0,0,1]), t=2.0)": (250, "axis", 2, -0.01),
    "movel(pose_trans(here, p[0,0,0,0,0,0.5]), t=2.0)": (250, "axis", 2, 0.0),
}


@pytest.mark.parametrize("move", MOVES)
def test_a_move_ends_where_it_should_in_its_time(bench, move):
    took, kind, index, way = MOVES[move]
    arm = bench.controller.arm
    before = list(arm.q) if kind == "joint" else list(arm.tcp_pose)
    cycles = bench.run(function(f" q = get_actual_joint_positions()\n here = get_actual_tcp_pose()\n {move}"))
    assert bench.faults() == []
    after = list(arm.q) if kind == "joint" else list(arm.tcp_pose)
    assert after[index] - before[index] == pytest.approx(way, abs=1e-3)
    assert took is None or cycles == pytest.approx(took + 8, abs=8)


@pytest.mark.parametrize("fraction", [1.0, 0.5, 0.02])
@pytest.mark.parametrize(
    ("move", "speed"), [("speedj([0.1,0,0,0,0,0], 1.0, 9)", 0.1), ("speedl([0,0,0.02,0,0,0], 0.5, 9)", 0.02)]
)
def test_a_speed_is_reached_at_the_part_of_it_that_the_slider_says(bench, move, speed, fraction):
    bench.controller.slider = fraction
    bench.programs.load(function(f" {move}"))
    for _ in range(1000):
        bench.controller.cycle()
    arm = bench.controller.arm
    assert (arm.qd[0] if move.startswith("speedj") else arm.tcp_speed[2]) == pytest.approx(fraction * speed, rel=1e-3)


def test_settings_reach_the_controller(bench):
    bench.run(
        function(
            " set_tcp(p[0,0,0.1,0,0,0])\n set_payload(1.5, [0,0,0.05])\n set_digital_out(1, True)\n"
            " set_tool_digital_out(0, True)\n write_output_integer_register(3, 7)\n"
            " write_output_boolean_register(70, True)\n textmsg(get_digital_out(1))"
        )
    )
    c = bench.controller
    assert (c.payload, c.payload_cog, c.digital_outputs) == (1.5, (0.0, 0.0, 0.05), 1 << 1 | 1 << 16)
    assert c.arm.tcp[2, 3] == pytest.approx(0.1)
    assert (c.registers.out_int[3], c.registers.bits["output"][70]) == (7, True)
    assert bench.texts(0) == ["True"]


def test_a_secondary_program_runs_beside_the_main_one(bench):
    bench.programs.load(function(" sleep(10)"))
    for _ in range(20):
        bench.controller.cycle()
    bench.programs.load("sec other():\n set_digital_out(0, True)\nend\n")
    assert bench.controller.digital_outputs == 1
    bench.programs.load("sec other():\n movej([0,0,0,0,0,0])\nend\n")
    assert bench.controller.running
    assert bench.faults() == [(2, "compile_error_name_not_found:movej:")]


#: programs that cannot be read: the line, and the message
UNREADABLE = {
    function(" nosuch(1)"): (2, "compile_error_name_not_found:nosuch:"),
    function(" x = y"): (2, "compile_error_name_not_found:y:"),
    function(" run nosuch()"): (2, "compile_error_name_not_found:nosuch:"),
    function(" movej([0,0,0,0,0,0)"): (2, "syntax_error_on_line:2:)"),
    function(" movej([1,0,0,0,0,0])\n x = $5"): (3, "syntax_error_on_line:3:$"),
    function(" 1 = 2"): (2, "syntax_error_on_line:2:="),
    "def program():\n if True:\nend\n": (4, "syntax_error_on_line:4:end of line"),
}


@pytest.mark.parametrize("text", UNREADABLE, ids=[text for _, text in UNREADABLE.values()])
def test_what_cannot_be_read_is_said_and_moves_nothing(bench, text):
    bench.programs.load(text)
    assert bench.faults() == [UNREADABLE[text]]
    for _ in range(20):
        bench.controller.cycle()
        assert not bench.controller.running
    assert bench.controller.arm.steady


#: programs that cannot go on, by their last line: the message
UNABLE = {
    "x = 1 / 0": "division by zero",
    "x = [1][3]": "index out of range",
    "while True:\n end": "infinite loop",
    "movel(p[3,0,0,0,0,0], v=-1)": "v must be more than 0",
    "movej(p[3,0,0,0,0,0])": "out of reach",
    "movej([1,2,3])": "six numbers are expected",
    "movej([0,0,0,0,0,0], speed=3)": "movej: got an unexpected keyword",
    "x = 1 + True": "a number is expected",
    "if 1:\n end": "a condition must be True or False",
    "def f():\n f()\n end\n f()": "too deep",
    'x = "ab"\n while True:\n x = str_cat(x, x)\n end': "too long",
    "x = 3\n while True:\n x = x * x\n end": "too large",
    "break": "outside of a loop",
}


@pytest.mark.parametrize("lines", UNABLE)
def test_what_cannot_go_on_is_said_and_ends(bench, lines):
    before = bench.controller.arm.q.copy()
    bench.run(function(f" {lines}"))
    ((line, said),) = bench.faults()
    assert 2 <= line <= 5
    assert UNABLE[lines] in said
    assert bench.controller.arm.q == pytest.approx(before)


WORDS = [
    "def f():",
    "end",
    "if x:",
    "while True:",
    "x",
    "=",
    "1",
    "(",
    ")",
    "[",
    "]",
    "movej",
    "\n",
    "sync()",
    "-",
    "p[",
    ",",
]


@settings(max_examples=150, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=30).map(" ".join) | st.text(max_size=60))
def test_any_text_is_read_or_refused_with_its_place(text):
    try:
        parse(text)
    except ScriptFault as fault:
        assert 1 <= fault.line <= text.count("\n") + 1
        assert fault.column >= 1


ODD = [
    "x = 1e300 * 1e300",
    "x = [x, x]",
    "x[x] = p[0,0,0,0,0,0]",
    "movej(x)",
    "movel(p[x,x,x,x,x,x])",
    "speedj([9000,0,0,0,0,0], 1)",
    "servoj(get_actual_joint_positions(), lookahead_time=x)",
    "write_output_integer_register(0, 1e300)",
    "write_output_float_register(x, x)",
    "set_tcp(p[1e300,0,0,0,0,0])",
    "set_payload(x, x)",
    "set_digital_out(-1, True)",
    "x = pose_inv(x)",
    "x = log(0, x)",
    'x = "a"',
    "while True:\n x = x + 1\n end",
    "t = run f()\n kill t\n join t",
    "f()",
    "halt",
    "powerdown()",
    "sleep(-1)",
]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from(ODD), max_size=5))
def test_no_program_stops_the_controller(lines):
    bench = Bench()
    bench.programs.load("def program():\nx = 1\ndef f():\nsync()\nend\n" + "\n".join(lines) + "\nend\n")
    for _ in range(30):
        bench.controller.cycle()
    assert bench.controller.time == pytest.approx(0.24)
    for name, ask in OUTPUTS.items():
        assert pack([OUTPUT_FIELDS[name].kind], [ask(bench.controller)])
    assert robot_state(bench.controller)
    assert realtime_packet(bench.controller)


@pytest.mark.parametrize("port", [30001, 30002, 30003])
def test_each_port_takes_programs(port, own_hosts):
    stand_in = Ur5StandIn(next(own_hosts), StandInWorld())
    stand_in.start()
    try:
        with Wire(stand_in.host, 30001) as events, Wire(stand_in.host, port) as wire:
            wire.socket.sendall(b"def hello():\n  textmsg(1 + 1)\nend\n")
            texts = (body[10:] for kind, body in messages(events) if kind == 20 and body[9] == 0)
            assert next(texts) == b"2"
    finally:
        stand_in.stop()


def test_what_a_read_only_port_is_sent_is_not_run(own_hosts):
    stand_in = Ur5StandIn(next(own_hosts), StandInWorld())
    stand_in.start()
    try:
        with Wire(stand_in.host, 30001) as events, Wire(stand_in.host, 30011) as wire:
            wire.socket.sendall(b"textmsg(1)\n")
            events.socket.sendall(b"textmsg(2)\n")
            texts = (body[10:] for kind, body in messages(events) if kind == 20 and body[9] == 0)
            assert next(texts) == b"2"
            assert math.isfinite(stand_in.state()["time"])
    finally:
        stand_in.stop()
