"""Arrays and records in mocks: beside a file, in a mapping, and in the record of the run, which is ticked again with them."""

import re
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import MocksError, RecordError
from stretch_bt.perception import Cloud, Contact, DepthFrame, Intrinsics, Sphere
from stretch_bt.runtime.check import check
from stretch_bt.runtime.mock_arrays import ARRAYS
from stretch_bt.runtime.mock_mapping import WrittenMocks
from stretch_bt.runtime.mock_value import mock_value
from stretch_bt.runtime.mocks_file import read_mocks
from stretch_bt.runtime.replay import replay
from stretch_bt.source import parse
from stretch_bt.tree.types import from_annotation

PIXEL = 0.5e-3
Y, X = np.mgrid[-80:81, -80:81] * PIXEL
CONTACT = Contact.from_heights(np.maximum(8e-3 - (X**2 + Y**2) / 40e-3, 0.0), PIXEL, noise=1e-4)
FRAME = DepthFrame.from_array(np.full((8, 9), 0.1), Intrinsics(9.0, 9.0, 4.0, 4.0, 9, 8), unit=1e-4)
TREE = """\
format: stretch-tree/1
devices: {camera: DepthCamera}
trees:
  main:
    out: {radius: Length}
    keys: {frame: DepthFrame, contact: Contact, sphere: Sphere}
    sequence:
      - capture: {frame}
      - segment_contact: {frame, contact}
      - fit_sphere: {contact, sphere}
      - set: {radius: sphere.radius}
"""
OF_RECORD = {"mocks": [{"match": "**/capture", "outputs": {"frame": {}}}]}
FILE = """\
format: stretch-mocks/1
tree: tree.yaml
mocks:
  - {{match: "**/capture", outputs: {{frame: {{}}}}}}
  - {{match: "**/segment_contact", outputs: {{contact: {{{contact}}}}}}}
"""
OTHERS = "rays: data/seen.npz#rays, noise: 0.1 mm, surface: surface.npy, labels: labels.npz, noise_area: 1"
READ = "points: data/seen.npz#points, " + OTHERS


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "tree.yaml").write_text(TREE, encoding="utf-8")
    (tmp_path / "data").mkdir()
    np.savez(tmp_path / "data" / "seen.npz", points=CONTACT.points, rays=CONTACT.rays)
    np.save(tmp_path / "surface.npy", CONTACT.surface)
    np.savez(tmp_path / "labels.npz", labels=CONTACT.labels.astype(np.int64))
    return tmp_path


def mocks_in(folder: Path, contact: str) -> Path:
    path = folder / "mocks.yaml"
    path.write_text(FILE.format(contact=contact), encoding="utf-8")
    return path


def test_a_file_names_arrays_beside_it(folder, run):
    path = mocks_in(folder, READ)
    assert check(path) == []
    result = run(folder / "tree.yaml", mocks=path)
    assert result.status == "SUCCESS", result.reason
    assert result.keys["contact"].labels.dtype == np.uint8
    np.testing.assert_array_equal(result.keys["contact"].points, CONTACT.points)
    for file in ("data/seen.npz", "surface.npy", "labels.npz"):
        (folder / file).unlink()
    assert replay(result.record).identical


def test_a_mapping_takes_records_and_arrays(run):
    some = {"points": CONTACT.points, "rays": CONTACT.rays, "labels": CONTACT.labels, "surface": CONTACT.surface}
    for contact in (CONTACT, {**some, "noise": "0.1 mm", "noise_area": 1}):
        mocks = {"mocks": [*OF_RECORD["mocks"], {"match": "**/segment_contact", "outputs": {"contact": contact}}]}
        result = run(TREE, mocks=mocks)
        assert result.status == "SUCCESS", result.reason
        assert result.outputs["radius"]["value"] == pytest.approx(20.0, rel=0.2)
        assert replay(result.record).identical
    assert isinstance(result.keys["contact"], Contact)
    assert repr(result.keys["contact"]).startswith("<mocked Contact with points=<float64 (")


def test_a_record_without_its_arrays_is_said_to_be_damaged(run):
    mocks = {"mocks": [*OF_RECORD["mocks"], {"match": "**/segment_contact", "outputs": {"contact": CONTACT}}]}
    result = run(TREE, mocks=mocks)
    (Path(result.record) / ARRAYS).write_bytes(b"no archive")
    with pytest.raises(RecordError, match=ARRAYS):
        replay(result.record)


RECORDS = {
    "contact": CONTACT,
    "frame": FRAME,
    "cloud": Cloud(np.ones((2, 3)), np.ones(2), np.ones((2, 3)), np.ones(2, np.int64), np.ones((2, 3), np.int64)),
    "sphere": Sphere(0.02, 1e-5, np.zeros(3), np.ones(3), 50.0, 0.1),
    "touch": Touch(0.1, 1e-5),
}


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_comes_back_as_it_was(name):
    record = RECORDS[name]
    found = read_mocks({"mocks": [{"match": "x", "outputs": {"y": record}}]})
    [again] = (mock_value(v, from_annotation(type(record)), "y", found.arrays) for v in found.rules[0].outputs["y"])
    assert type(again) is type(record)
    for field in type(record).__dataclass_fields__:
        one, other = getattr(again, field), getattr(record, field)
        assert type(one) is type(other)
        np.testing.assert_equal(one, other)


def test_what_no_file_can_hold_is_left_out():
    from stretch_bt.behaviors.records import Rise
    from stretch_bt.perception import HeightTracker

    assert WrittenMocks({"mocks": [{"outputs": {"rise": Rise(3, HeightTracker())}}]}).text.endswith("frames: 3\n")


def test_nested_lists_are_arrays():
    value = parse("{labels: [[0, 2], [255, 1]], points: [[0, 0.5, 1]]}", "mocks.yaml")
    made = mock_value(value, from_annotation(Contact), "contact")
    assert made.labels.dtype == np.uint8
    assert made.points.tolist() == [[0.0, 0.5, 1.0]]


#: the fields of a contact that a file gives, and what is said of them
WRONG = {
    "points: data/sen.npz#points": ("file-missing", "'data/sen.npz' cannot be read", "did you mean 'seen.npz'"),
    "points: data/seen.npz#point": ("value", "no array 'point'", "did you mean 'points'"),
    "points: data/seen.npz": ("value", "seen.npz holds points, rays", "as in 'seen.npz#points'"),
    "points: points": ("type-mismatch", "takes an array, not 'points'", "as in 'depth.npy'"),
    "labels: [[300]]": ("type-mismatch", "takes an array of uint8, not of int64", "convert it"),
    "labels: [[1], [1, 2]]": ("type-mismatch", "takes an array", "each row of one length"),
    "pints: surface.npy": ("attribute-unknown", "Contact has no 'pints'", "did you mean 'points'"),
}


@pytest.mark.parametrize("fields", WRONG)
def test_wrong_arrays_are_told_in_their_place(folder, fields):
    code, message, hint = WRONG[fields]
    found = check(mocks_in(folder, fields))
    assert [(d.code, d.line) for d in found] == [(code, 5)]
    assert re.search(re.escape(message), found[0].message)
    assert hint in found[0].hint


def test_a_class_that_refuses_its_fields_says_why():
    fields = {
        **dict.fromkeys(("plane_distance", "hand_height", "stretch", "pose"), "none"),
        "time": "0 s",
        "raw": np.zeros((2, 2), np.uint16),
        "unit": 1e-4,
    }
    camera = {"fx": 1, "fy": 1, "cx": 0, "cy": 0, "width": 3, "height": 2, "distortion": [0, 0, 0, 0, 0]}
    mocks = {"mocks": [{"match": "**/capture", "outputs": {"frame": {**fields, "intrinsics": camera, "sequence": 1}}}]}
    found = read_mocks(mocks)
    with pytest.raises(Exception, match=r"frame: a depth image of shape \(2, 3\) fits these intrinsics"):
        mock_value(found.rules[0].outputs["frame"][0], from_annotation(DepthFrame), "frame", found.arrays)


def test_mistakes_of_a_mapping_name_the_mapping(run):
    with pytest.raises(MocksError, match="Contact has no 'pints'"):
        run(TREE, mocks={"mocks": [{"match": "**/segment_contact", "outputs": {"contact": {"pints": X}}}]})


NUMBERS = """\
format: stretch-tree/1
devices: {arm: Arm, camera: DepthCamera}
trees:
  main:
    out: {height: Length, line: "list[float]"}
    sequence:
      - capture: {frame}
      - segment_contact: {frame, contact}
      - track_height: {frame, contact, height}
      - track_height: {frame, contact, height}
      - measure_outline: {contact, line}
      - check: arm.force < 1 N
      - check: arm.force > 1 N
"""


def test_an_array_stands_for_a_list_of_values(tmp_path, run):
    (tmp_path / "tree.yaml").write_text(NUMBERS, encoding="utf-8")
    np.savez(tmp_path / "of.npz", height=[1e-3, 2e-3], force=[0.5, 2.0], line=[1.0, 2.0, 3.0])
    mocks = """\
format: stretch-mocks/1
tree: tree.yaml
mocks:
  - {match: "**/capture", outputs: {frame: {}}}
  - {match: "**/segment_contact", outputs: {contact: {}}}
  - {match: "**/track_height", outputs: {height: of.npz#height}}
  - {match: "**/measure_outline", outputs: {line: of.npz#line}}
readings: {arm.force: of.npz#force}
"""
    path = tmp_path / "mocks.yaml"
    path.write_text(mocks, encoding="utf-8")
    result = run(tmp_path / "tree.yaml", mocks=path)
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["height"]["value"] == pytest.approx(1.0)  # each place has a list of its own
    assert result.outputs["line"]["value"] == [1.0, 2.0, 3.0]
    assert replay(result.record).identical
    path.write_text(mocks.replace("of.npz#force", "of.npz"), encoding="utf-8")
    assert "say which, as in 'of.npz#height'" in check(path)[0].hint
