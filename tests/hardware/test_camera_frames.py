"""What is read of a camera: any bytes of its stand-in, and any frames."""

import itertools
import os
import socket
import subprocess
import sys
from contextlib import suppress
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.channel import Channel
from stretch_bt.hardware.messages import Lost
from stretch_bt.hardware.realsense import sources
from stretch_bt.hardware.realsense.judge import Judge, TimedFrame
from stretch_bt.hardware.realsense.messages import CODEC, CameraSettings
from stretch_bt.hardware.realsense.sources import Source
from stretch_bt.hardware.realsense.wire import CameraDescription, Packets, SentFrame, _packet

CAMERA = CameraDescription(serial="1", width=4, height=3, rate=30, unit=1e-4, fx=5.0, fy=5.0, cx=2.0, cy=1.5)
CAMERA_SETTINGS = {
    **dict.fromkeys(("serial", "file", "host", "record")),
    "port": 0,
    "width": 4,
    "height": 3,
    "rate": 30.0,
    "lost_after": 0.4,
    "noisy": True,
}
TIMES = st.floats(-1e11, 1e11)
PICTURES = st.builds(SentFrame, st.integers(0, (1 << 64) - 1), TIMES, st.binary(max_size=40))


def in_pieces(packets, data, sizes):
    """Yield what packets are cut out of bytes that come in pieces."""
    at = 0
    for size in [*sizes, len(data)]:
        yield from packets.feed(data[at : at + size])
        at += size


@given(st.lists(PICTURES, max_size=6), st.lists(st.integers(1, 60), max_size=20))
def test_frames_survive_the_wire_in_any_pieces(pictures, sizes):
    packets = Packets()
    data = b"".join(p.encode() for p in (CAMERA, *pictures))
    assert list(in_pieces(packets, data, sizes)) == [CAMERA, *pictures]
    assert packets.broken == 0


@given(st.lists(st.binary(max_size=60), max_size=8))
def test_any_bytes_are_no_frames(chunks):
    packets, found = Packets(), []
    try:
        for chunk in chunks:
            found += packets.feed(chunk)
    except InvalidInput as error:
        assert len(str(error)) < 200
    assert found == []


@given(st.lists(PICTURES, min_size=1, max_size=4), st.integers(0, 10_000), st.integers(1, 255))
def test_a_byte_that_is_changed_costs_its_frame_or_the_connection(pictures, at, change):
    """And never gives one that was not sent."""
    data = bytearray(b"".join(p.encode() for p in pictures))
    data[at % len(data)] ^= change
    found = []
    with suppress(InvalidInput):
        for packet in Packets().feed(bytes(data)):
            found.append(packet)
    assert all(packet in pictures for packet in found)
    assert len(found) <= len(pictures)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b"{}", "Field required"),
        (CAMERA.model_dump_json().replace("0.0001", "NaN").encode(), "valid|finite"),
        (CAMERA.model_dump_json().replace('"width":4', '"width":0').encode(), "greater"),
        (CAMERA.model_dump_json().replace('"width":4', '"width":100000').encode(), "less"),
        (b"[" * 4000, "recursion|Invalid JSON|depth"),
    ],
)
def test_what_describes_no_camera(body, said):
    with pytest.raises(InvalidInput, match=said):
        list(Packets().feed(_packet(1, body)))


@given(st.integers(0, 255), st.binary(max_size=30))
def test_a_packet_of_any_kind(kind, body):
    try:
        found = list(Packets().feed(_packet(kind, body)))
    except InvalidInput:
        return
    assert kind == 2
    assert found[0].pixels == body[16:]


SHOTS = st.lists(
    st.tuples(st.integers(0, 12), st.integers(0, 12), st.floats(0.001, 0.5), st.integers(0, 3)), max_size=40
)


@given(SHOTS, st.booleans())
def test_any_frames_are_given_out_once_and_in_their_order(shots, noisy):
    """With their exposure never after they came, and every frame counted; a camera that is restarted may begin anew."""
    judge, now, taken, events = Judge(0.4, noisy, 0.0), 0.0, [], 0
    for number, time, wait, seed in shots:
        now += wait
        image = np.random.default_rng(seed).integers(0, 3, (48, 64)).astype(np.uint16) * (seed > 0)
        good = judge.take(TimedFrame(number, time / 10, now, image))
        events, judge.event = events + (judge.event is not None), None
        assert (good is None) == (judge.bad is not None)
        if good is not None:
            assert good.exposed <= good.arrived == now
            assert judge.silent(now) == 0.0
            taken.append((good.number, good.time))
    assert judge.counters.received == len(shots)
    assert min(asdict(judge.counters).values()) >= 0
    if not events:
        assert taken == sorted(set(taken))


def test_noise_that_stands_in_a_strip_is_a_torn_image():
    random = np.random.default_rng(0)
    first, second = (random.integers(1590, 1610, (480, 640)).astype(np.uint16) for _ in range(2))
    judge = Judge(1.0, noisy=True, began=0.0)
    assert judge.take(TimedFrame(1, 0.0, 0.0, first)) is not None
    torn = second.copy()
    torn[450:] = first[450:]
    assert judge.take(TimedFrame(2, 0.03, 0.03, torn)) is None
    assert judge.bad == "its images are torn"
    cut = random.permuted(second, axis=1)
    cut[240:] = 0
    assert judge.take(TimedFrame(3, 0.07, 0.07, cut)) is None
    assert judge.take(TimedFrame(4, 0.1, 0.1, second)) is not None
    assert judge.counters.torn == 2
    still = Judge(1.0, noisy=False, began=0.0)
    assert [still.take(TimedFrame(k, k / 30, k / 30, first)) is not None for k in range(3)] == [True] * 3


def test_a_frame_that_was_held_up_is_as_old_as_its_exposure():
    judge, random = Judge(10.0, noisy=False, began=0.0), np.random.default_rng(0)
    image = random.integers(1, 9, (4, 4)).astype(np.uint16)
    way = [0.02, 0.03, 0.02, 0.32, 0.29, 0.02]
    for k, late in enumerate(way):
        shot = judge.take(TimedFrame(k, 50.0 + k, k + late, image))
        assert shot.exposed == pytest.approx(k + 0.02, abs=1e-3)  # the drift that a clock may have
    assert judge.event is None
    judge.take(TimedFrame(9, 70.0, 10.0, image))
    assert "jumped ahead by 1" in judge.event


# (exposure and arrival of three frames, whether the clock is said to have jumped)
HELD_UP = [
    ([(0.1, 1.5), (0.13, 1.51), (1.55, 1.6)], False),  # for as long as it took the first one to come
    ([(0.1, 1.5), (0.13, 1.51), (5.05, 5.1)], True),  # which is over by then
    ([(0.1, 0.2), (0.13, 0.23), (1.1, 0.3)], True),  # the first one came at once
]


@pytest.mark.parametrize(("frames", "jumped"), HELD_UP)
def test_first_frames_that_were_held_up_are_no_clock_that_jumps(frames, jumped):
    judge, image = Judge(10.0, noisy=False, began=0.0), np.ones((4, 4), np.uint16)
    shots = [judge.take(TimedFrame(k, exposed, came, image)) for k, (exposed, came) in enumerate(frames)]
    assert (judge.event is not None) is jumped
    assert shots[-1].exposed == frames[-1][1]


def test_a_camera_may_take_its_time_for_the_first_frame_and_no_silence_reaches_into_the_future():
    judge, image = Judge(0.4, noisy=False, began=0.0), np.ones((4, 4), np.uint16)
    assert judge.take(TimedFrame(1, 0.0, 2.0, image)) is not None
    assert judge.event is None
    judge.excuse(5.0, now=2.1)
    assert judge.silent(2.7) == pytest.approx(0.6)
    assert judge.take(TimedFrame(2, 0.7, 2.7, image)) is not None
    assert "no good frame came for 0.6 s" in judge.event


class Endless:
    """A syncer to which frames come faster than they are taken."""

    def poll_for_frames(self):
        return self

    def size(self):
        return 1


def test_a_turn_ends_while_frames_keep_coming():
    source = Source.__new__(Source)
    source._syncer, source._shot = Endless(), lambda frames: frames
    assert 1 <= len(list(itertools.islice(source.shots(0.0), 100))) < 100


LOSES = """
import mmap, sys
from functools import partial
from pathlib import Path
from stretch_bt.frames import Intrinsics
from stretch_bt.hardware.realsense import process

class Loses:
    unit, broken, ended, intrinsics = 1e-4, 0, False, Intrinsics(10.0, 10.0, 2.0, 1.5, 4, 3)
    start = described = lambda self: None
    def shots(self, within):
        raise OSError("unplugged")
    def stop(self):
        Path(sys.argv[3]).write_text("whole")

process.open_source = lambda settings: Loses()
memory = mmap.mmap(int(sys.argv[2]), 0)
process.keep(int(sys.argv[1]), process.CODEC, partial(process.CameraKeeper, memory), opening=4.0, package="{}")
"""


def test_a_recording_is_ended_also_when_its_camera_is_lost(tmp_path):
    ours, theirs = socket.socketpair()
    channel, given = Channel(ours, CODEC), [theirs.fileno(), os.memfd_create("frames")]
    os.ftruncate(given[1], 1 << 12)
    channel.send(CameraSettings(**{**CAMERA_SETTINGS, "host": None}))
    command = [sys.executable, "-c", LOSES, *map(str, given), str(tmp_path / "recording")]
    assert subprocess.run(command, pass_fds=given, timeout=60).returncode == 0
    theirs.close()
    os.close(given[1])
    assert channel.drain()[-1] == Lost("unplugged", missing=False)
    channel.close()
    assert (tmp_path / "recording").read_text() == "whole"


def test_the_library_is_there_before_frames_come(monkeypatch):
    """Frames that waited for it would be taken for the quickest."""

    def missing():
        raise ImportError("not here")

    monkeypatch.setattr(sources, "library", missing)
    with socket.create_server(("127.0.0.1", 0)) as server:
        host, port = server.getsockname()
        with pytest.raises(ImportError):
            sources.open_source(CameraSettings(**{**CAMERA_SETTINGS, "host": host, "port": port}))
        server.setblocking(False)
        with pytest.raises(BlockingIOError):
            server.accept()
