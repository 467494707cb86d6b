"""Left and right by shape, where neither names nor feet tell them."""

import numpy as np
import pytest

from lanindex.body.recognition import Rig, by_shape

JOINTS = {  # facing +z, y up, so that right is at -x: parent, and where in cm
    "pelvis": ("", (0, 90, 0)),
    "hip": ("pelvis", (-10, 88, 0)),
    "knee": ("hip", (-10, 48, 6)),
    "ankle": ("knee", (-10, 8, 0)),
    "other hip": ("pelvis", (10, 88, 0)),
    "other knee": ("other hip", (10, 48, 6)),
    "other ankle": ("other knee", (10, 8, 0)),
    "chest": ("pelvis", (0, 130, 0)),
    "neck": ("chest", (0, 142, 0)),
    "head": ("neck", (0, 158, 0)),
    "shoulder": ("chest", (-18, 136, 0)),
    "elbow": ("shoulder", (-20, 108, -2)),
    "wrist": ("elbow", (-20, 82, 4)),
    "other shoulder": ("chest", (18, 136, 0)),
    "other elbow": ("other shoulder", (20, 108, -2)),
    "other wrist": ("other elbow", (20, 82, 4)),
}
NAMES = list(JOINTS)


def rig(places: np.ndarray) -> Rig:
    parents = [NAMES.index(parent) if parent else -1 for parent, _ in JOINTS.values()]
    names = tuple(f"J{number}" for number in range(len(NAMES)))
    return Rig(names, parents, np.repeat(places[None], 3, axis=0))


def sides(places: np.ndarray) -> dict[str, str]:
    """Return who plays the right limbs."""
    body, doubts = by_shape(rig(places))
    assert doubts == ()
    return {joint: NAMES[body["R" + joint]] for joint in ("Hip", "Knee", "Ankle", "Wrist")}


RIGHT = {"Hip": "hip", "Knee": "knee", "Ankle": "ankle", "Wrist": "wrist"}
LEFT = {joint: f"other {name}" for joint, name in RIGHT.items()}
PLACES = np.array([place for _, place in JOINTS.values()], float)


@pytest.mark.parametrize("degrees", [0, 90, 180, 251])
@pytest.mark.parametrize("away", [0, 500])
def test_knees_and_hands_lie_in_front(degrees: int, away: int) -> None:
    turn = np.radians(degrees)
    x, y, z = PLACES.T
    turned = np.stack(
        (x * np.cos(turn) + z * np.sin(turn) + away, y + away, z * np.cos(turn) - x * np.sin(turn))
    ).T
    assert sides(turned) == RIGHT


def test_what_bends_the_other_way_faces_the_other_way() -> None:
    assert sides(PLACES * (1, 1, -1)) == LEFT


def test_knees_alone_tell_it_too() -> None:
    hanging = PLACES.copy()
    for joint in ("elbow", "wrist", "other elbow", "other wrist"):
        hanging[NAMES.index(joint), 2] = 0
    assert sides(hanging) == RIGHT
    assert sides(hanging * (1, 1, -1)) == LEFT


def test_two_joints_are_in_one_place_by_the_size_of_the_body() -> None:
    poses = np.stack([PLACES * size for size in (1, 1, 2, 9, 9)])
    parents = [NAMES.index(parent) if parent else -1 for parent, _ in JOINTS.values()]
    middle = Rig(tuple(NAMES), parents, poses)
    assert middle.nothing == pytest.approx(2 * 150 * 0.003)


@pytest.mark.parametrize("turned", [1, -1])
def test_names_that_tell_the_side_are_believed_before_the_shape(turned: int) -> None:
    shown = rig(PLACES * (1, 1, turned))
    names = tuple(
        f"joint{number}_{'L' if name.startswith('other') else 'R'}" if shown.parents[number] > 0
        else f"joint{number}"
        for number, name in enumerate(NAMES)
    )  # fmt: skip
    body, _ = by_shape(Rig(names, shown.parents, shown.poses))
    assert {joint: NAMES[body["R" + joint]] for joint in RIGHT} == RIGHT
