"""`scene explain`, `scene show` and `run --stats`."""

import json
import re
import xml.etree.ElementTree as ET

import cv2
import numpy as np
import pytest

SCENE = """\
format: stretch-scene/1
doc: A ball on a post.
object: {type: sphere, diameter: 20 mm, stiffness: 2 N/mm, base: 40 mm}
conditions: {stretch: 30 mm, depth: 6 mm}
"""
#: by name: what is written after it, and what the command then says
SHOWN = {
    "plain": ("fidelity: hertz\n", ""),
    "dropped": ("fidelity: hertz\neffects: {dropout: {share: 1.0}}\n", ""),
    "refused": ("fidelity: hertz\n", "nothing is pressed: a stretch of 120 mm"),
    "cup": ("fidelity: hertz\nsupport: {type: cup, diameter: 30 mm, rim: 45 mm}\n", ""),
    "deep": ("fidelity: hertz\n", "nothing is pressed: the membrane wraps"),
    "table": ("fidelity: hertz\n", "the hand stands on the table: pressed 8 mm of 12 mm"),
    "sheet": ("effects: {white_noise: on, sag: on}\n", ""),
    "round": ("fidelity: axisymmetric\n", ""),
}
TREE = """\
format: stretch-tree/1
devices: {camera: DepthCamera}
keys: {frame: DepthFrame}
trees:
  main:
    sequence:
      - capture: {frame: $frame}
      - capture: {frame: $frame}
"""


@pytest.fixture
def scene(tmp_path):
    """Write the scene with something after it, and return its name."""

    def write(name, after=""):
        text = SCENE + after
        if name == "refused":
            text = text.replace("stretch: 30 mm", "stretch: 120 mm")
        if name == "deep":
            text = text.replace("depth: 6 mm", "depth: 60 mm")
        if name == "table":
            text = text.replace("sphere", "cylinder").replace("base: 40 mm", "height: 8 mm").replace("6 mm", "12 mm")
        (tmp_path / f"{name}.yaml").write_text(text)
        return f"{name}.yaml"

    return write


def test_explain_json_is_the_contract(cli):
    code, out, _ = cli("scene", "explain", "water_balloon", "--json")
    assert code == 0
    told = json.loads(out)
    assert told["scene"] == "water_balloon"
    assert all(value > 0 for value in told["tolerance"].values())
    for effect in told["effects"]:
        assert effect.keys() >= {"name", "on", "observable", "estimate", "threshold", "unit", "cost_ms", "why"}
    assert {effect["name"] for effect in told["effects"] if effect["on"]} >= {"compliance"}


def test_explain_says_sizes_and_what_is_close(cli, scene):
    name = scene("near", "tolerance: {height: 0.2 mm}\neffects: {latency: on}\n")
    code, out, _ = cli("scene", "explain", name)
    assert code == 0
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line}
    assert rows["repeatability"][1:8] == ["off", "height", "0.03", "mm", "0.2", "mm", "0.02"]
    assert rows["latency"][1:4] == ["on", "height", "0.0234"]
    assert "a sphere cannot have: " in out
    (close,) = [line for line in out.splitlines() if line.startswith("narrow: ")]
    assert "fixed_pattern on (height 0.5 mm of 0.2 mm)" in close
    assert "latency" not in close
    (choice,) = [line for line in out.splitlines() if line.startswith("predicted ")]
    assert "of 0.2 mm" in choice
    assert "ms of CPU" in out


def test_explain_with_a_tolerance_of_a_run(cli, scene):
    name = scene("asked", "tolerance: {height: 0.2 mm, stiffness: 5 %}\n")
    code, out, _ = cli("scene", "explain", name, "--tolerance", "stiffness=2%", "--json")
    told = json.loads(out)
    assert code == 0
    assert told["tolerance"] == {"height": 2e-4, "stiffness": 0.02}
    assert told["choice"]["asked"] == {"stiffness": 0.02}
    assert set(told["choice"]["on"]) == {effect["name"] for effect in told["effects"] if effect["on"]}
    code, out, err = cli("scene", "explain", name, "--tolerance", "stiffness=0.001%")
    assert (code, out) == (2, "")
    assert "the best that can be had is stiffness" in err


def test_run_with_a_tolerance(cli, scene, tmp_path):
    (tmp_path / "look.yaml").write_text(TREE)
    run = ("run", "look.yaml", "--scene", scene("soft"), "--quiet")
    code, out, _ = cli(*run, "--tolerance", "stiffness=5%", "--tolerance", "height=0.5mm", "--out", "a")
    assert code == 0
    assert out.count("predicted ") == 1
    code, out, _ = cli(*run, "--tolerance", "stiffness=0.001%", "--out", "b", "--json")
    told = json.loads(out)
    assert (code, told["status"], told["record"]) == (2, "ERROR", None)
    assert "the best that can be had is stiffness" in told["reason"]


def test_explain_of_a_scene_with_a_mistake(cli, scene):
    name = scene("wrong", "effects: {plasticity: on}\n")
    code, out, err = cli("scene", "explain", name)
    assert (code, out) == (2, "")
    assert f"{name}:5:11 error[effect-impossible]" in err


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name == "round" else []) for name in SHOWN]
)
def test_show_draws_three_panels(cli, scene, tmp_path, name):
    after, said = SHOWN[name]
    code, out, err = cli("scene", "show", scene(name, after))
    assert (code, out.strip()) == (0, f"{name}.svg")
    assert said in err
    root = ET.parse(tmp_path / f"{name}.svg").getroot()
    texts = " ".join(e.text for e in root.iter("{http://www.w3.org/2000/svg}text"))
    assert all(heading in texts for heading in ("scene, cut", "membrane, from above", "depth frame"))
    assert len(list(root.iter("{http://www.w3.org/2000/svg}image"))) >= 4  # two maps and their bars
    assert ("nothing is pressed" in texts) == said.startswith("nothing is pressed")
    drawn = re.sub(r"base64,[^\"]*", "", (tmp_path / f"{name}.svg").read_text())
    assert not re.search(r"\bnan\b|\binf\b", drawn)


def test_show_writes_pixels_too(cli, scene, tmp_path):
    code, out, _ = cli("scene", "show", scene("plain", "fidelity: hertz\n"), "--out", "picture.png")
    assert (code, out.strip()) == (0, "picture.png")
    image = cv2.imread(str(tmp_path / "picture.png"))
    assert image.shape[1] == 2640
    assert np.ptp(image) == 255


@pytest.mark.parametrize(("out", "said"), [("picture.pdf", ".svg or .png"), ("no/folder.svg", "cannot be written")])
def test_show_refuses_what_it_cannot_write(cli, scene, out, said):
    code, _, err = cli("scene", "show", scene("plain", "fidelity: hertz\n"), "--out", out)
    assert code == 2
    assert said in err


def test_stats_are_shown_when_asked_for(cli, scene, tmp_path):
    (tmp_path / "look.yaml").write_text(TREE)
    name = scene("stats", "fidelity: hertz\neffects: {compliance: on, white_noise: on, dropout: off}\n")
    quiet = json.loads(cli("run", "look.yaml", "--scene", name, "--json", "-q")[1])
    assert "stats" not in quiet
    code, out, _ = cli("run", "look.yaml", "--scene", name, "--json", "--stats", "-q")
    assert code == 0
    rows = {row["name"]: row for row in json.loads(out)["stats"]}
    assert rows["render"]["count"] == 1  # nothing moved between the frames
    assert rows["white_noise"]["count"] == 2
    assert rows["white_noise"]["cpu_seconds"] > 0
    assert (rows["compliance"]["cpu_seconds"], rows["compliance"]["within"]) == (None, "contact")
    assert "dropout" not in rows
    _, out, _ = cli("run", "look.yaml", "--scene", name, "--stats", "-q")
    assert "white_noise" in out
    assert "in contact" in out


def test_stats_without_a_twin(cli, tmp_path):
    (tmp_path / "wait.yaml").write_text(
        "format: stretch-tree/1\ntrees:\n  main:\n    sequence:\n      - wait: {duration: 1 s}\n"
    )
    _, out, _ = cli("run", "wait.yaml", "--stats", "-q")
    assert "nothing was simulated" in out
