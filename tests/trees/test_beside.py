"""Objects beside the membrane, where the twin has no equilibrium: the task fails, and the hand is raised."""

import pytest

SCENE = """\
format: stretch-scene/1
object: {{{thing}, position: {{x: 0 mm, y: {y} mm}}}}
effects: none
"""
CUBE = "type: box, length: 40 mm, width: 40 mm, height: 40 mm, edge: 1 mm, rigid: true"


@pytest.mark.parametrize(
    ("tree", "thing", "y", "said"),
    [
        ("palpate_stiffness", CUBE, 45, "main/force_limit: the indenter overlaps a clamp"),
        ("reconstruct", CUBE, 45, "main/approach/descend: the indenter overlaps a clamp"),
    ],
)
def test_a_hand_that_comes_down_beside_an_object_fails_and_is_raised(run, hand_at, tmp_path, tree, thing, y, said):
    scene, runners = tmp_path / "scene.yaml", []
    scene.write_text(SCENE.format(thing=thing, y=y), encoding="utf-8")
    result = run(tree, cell=hand_at(60), scene=scene, watch=runners.append)
    assert (result.status, result.reason[: len(said)]) == ("FAILURE", said)
    assert runners[0].cell.truth()["force"] == 0.0
