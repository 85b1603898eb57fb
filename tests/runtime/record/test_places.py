"""What the log of a run leaves out: addresses of devices and folders of the disk."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import DeviceLost, NoAnswer
from stretch_bt.runtime.record import RecordReader, RunRecord
from stretch_bt.runtime.record.places import Places
from stretch_bt.runtime.replay.compare import compare

PLACES = Places(["lab-ur5", "fe80::1"], ["/data/Max Weber/lab"])
#: a text -> what is left of it
TEXTS = {
    "cannot be reached at 192.168.1.10 port 30004": "cannot be reached at its host port 30004",
    "cannot be reached at lab-ur5 (timed out)": "cannot be reached at its host (timed out)",
    "no answer from lab-ur5-2, nor from lab-ur5": "no answer from lab-ur5-2, nor from its host",
    "no such file: '/srv/lab/press.csv'": "no such file: 'press.csv'",
    "no such file: '/data/Max Weber/lab/press.csv'": "no such file: 'press.csv'",
    "/dev/ttyUSB0: permission denied": "ttyUSB0: permission denied",
    "main/approach: 5 N/mm at 2 mm/s, 1/3 of main/until/feel": "main/approach: 5 N/mm at 2 mm/s, 1/3 of main/until/feel",
    "version 1.2.3": "version 1.2.3",
}


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_loses_hosts_and_folders_alone(text: str) -> None:
    assert PLACES.without(text) == TEXTS[text]
    assert PLACES.left_out({"a": [text, 1.5, None], "b": {"c": text}}) == {
        "a": [TEXTS[text], 1.5, None],
        "b": {"c": TEXTS[text]},
    }


@given(st.text(st.sampled_from("ab/. -1:'(\n"), max_size=40))
def test_nothing_is_left_out_twice(text: str) -> None:
    once = PLACES.without(text)
    assert PLACES.without(once) == once


def test_a_record_holds_none_of_them(tmp_path: Path) -> None:
    record = RunRecord(tmp_path / "r")
    record.start({}, {"host": "lab-pc"}, PLACES)
    record.fault("arm", DeviceLost("arm", "no answer at lab-ur5 within 1 s"))
    record.unanswered("arm", NoAnswer("nothing in /srv/lab/press.csv"))
    record.status("main/load", "FAILURE", "main/load: no such file: '/srv/lab/press.csv'")
    record.write("main/table", "/srv/lab/press.csv", None, "main/load")
    record.command("arm", "load", {"file": "/srv/lab/press.csv"}, "main/load")
    record.note("error", reason="10.0.0.7 does not answer")
    record.close({"status": "FAULT", "reason": "no answer at lab-ur5 within 1 s"})
    log = (tmp_path / "r/events.jsonl").read_text()
    assert [place for place in ("lab-ur5", "/srv", "10.0.0.7") if place in log] == []
    [fault] = [item for item in RecordReader(tmp_path / "r").handed(-1) if item.kind == "fault"]
    assert fault.value.reason == "no answer at its host within 1 s"
    assert "lab-ur5" in json.loads((tmp_path / "r/result.json").read_text())["reason"]


def test_a_log_that_holds_them_is_the_same(tmp_path: Path) -> None:
    old = [{"type": "error", "reason": "no answer at 10.0.0.7"}, {"type": "write", "value": "/srv/lab/a.csv"}]
    new = [{"type": "error", "reason": "no answer at its host"}, {"type": "write", "value": "a.csv"}]
    assert compare(old, new).same
    assert not compare(old, [new[0], {"type": "write", "value": "b.csv"}]).same
