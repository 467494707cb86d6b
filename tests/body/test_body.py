"""Joints map by naming scheme, or by shape where names say nothing."""

import random
import re

import bvh_bodies
import numpy as np
import pytest
from bvh_bodies import SCHEMES, SIMPLE, hierarchy, named, person, played, still
from effort import examples
from hypothesis import given
from hypothesis import strategies as st

import lanindex
from lanindex import formats
from lanindex.alphabet import JOINT_CODES, JOINTS
from lanindex.body.recognition import keys
from lanindex.errors import BodyError
from lanindex.model import Motion


@pytest.mark.parametrize("scheme", SCHEMES)
def test_naming_schemes(scheme):
    names = named(SCHEMES[scheme])
    motion = formats.read("x.bvh", data=person(names=names, ends=False))
    assert motion.skeleton.played() == played(names)
    assert motion.warnings == ()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_naming_schemes_with_end_sites(scheme):
    names = named(SCHEMES[scheme])
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert {joint: found[joint] for joint in played(names)} == played(names)


def test_a_hand_is_the_middle_fingers_first_joint():
    text = hierarchy(named(SCHEMES["Mixamo"]))
    thumb = "JOINT mixamorig:LeftHandThumb1 { OFFSET 9 0 9 CHANNELS 0 }\n"
    text = text.replace(
        "JOINT mixamorig:LeftHandMiddle1", thumb + "JOINT mixamorig:LeftHandMiddle1"
    )
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert found["LHand"] == "mixamorig:LeftHandMiddle1"


def test_tips_are_end_sites_where_there_is_nothing_else():
    names = {role: name for role, name in SIMPLE.items() if role[1:] not in ("Hand", "Toe")}
    names.pop("Head")
    tips = ["LWrist", "LAnkle"]
    text = hierarchy(names)
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert not {"LHand", "RHand", "LToe", "RToe", "Head"} & found.keys()
    for tip in (*tips, "RWrist", "RAnkle", "Neck"):
        text = text.replace(
            text[text.index(f"JOINT {tip}\n") :],
            text[text.index(f"JOINT {tip}\n") :].replace(
                "End Site\n{\nOFFSET 0.000000 0.000000 0.000000", "End Site\n{\nOFFSET 1 2 3", 1
            ),
        )
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert found["LHand"] == "LWrist End"
    assert found["RToe"] == "RAnkle End"
    assert found["Head"] == "Neck End"


def test_a_hand_whose_end_has_no_length_turns_with_its_wrist():
    text = hierarchy({role: name for role, name in SIMPLE.items() if role[1:] != "Hand"})
    joints = re.findall(r"(?:ROOT|JOINT) (\w+)", text)
    frames = np.zeros((3, 3 + 3 * len(joints)))
    frames[:, 1], frames[:, 3 + 3 * joints.index("RWrist")] = 92, (-40, 0, 40)
    found = formats.read("x.bvh", data=(text + bvh_bodies.motion(frames.tolist())).encode())
    played = found.skeleton.played()
    assert (played["RHand"], "LHand" in played) == ("RWrist End", False)
    codes = [found.skeleton.body[JOINT_CODES[it]] for it in ("RElbow", "RWrist", "RHand")]
    forearm, hand = np.diff(found.positions[:, codes], axis=1).transpose(1, 0, 2)
    lengths = np.linalg.norm(hand, axis=1) / np.linalg.norm(forearm, axis=1)
    np.testing.assert_allclose(lengths, 0.35, rtol=1e-4)
    turn = np.degrees(np.arctan2(-hand[:, 1], -hand[:, 0]))
    np.testing.assert_allclose(turn, (-40, 0, 40), atol=1e-2)


def forefeet(before: str) -> Motion:
    """Return a person whose forefeet lie straight under the ankles, their End Sites elsewhere."""
    names = SIMPLE | {"LToe": "LForeFoot", "RToe": "RForeFoot"}
    text = hierarchy(names).replace("OFFSET 0.000000 -6.000000 13.000000", "OFFSET 0 -8 0")
    text = text.replace("OFFSET 0.000000 0.000000 6.000000", before)
    return formats.read("x.bvh", data=still(text).encode())


def test_what_lies_straight_under_the_ankle_is_no_toe():
    motion = forefeet("OFFSET 0 -1 15")
    found = motion.skeleton.played()
    assert (found["LToe"], found["RToe"]) == ("LForeFoot End", "RForeFoot End")
    assert motion.warnings == ()
    assert lanindex.encode(motion).symbols("r_foot")[0].words == "forward low"


def test_a_foot_that_has_nothing_else_has_no_toe_and_says_so():
    motion = forefeet("OFFSET 0 0 0")
    assert not {"LToe", "RToe"} & motion.skeleton.played().keys()
    assert motion.warnings == tuple(
        f'no {side}Toe: "{side}ForeFoot" lies straight under the ankle' for side in "RL"
    )


def test_a_foot_that_is_pointed_throughout_keeps_its_toe():
    pointed = "OFFSET 0 -15 0"
    text = hierarchy(SIMPLE).replace("OFFSET 0.000000 -6.000000 13.000000", pointed, 1)
    assert pointed in text
    text = text.replace("OFFSET 0.000000 0.000000 6.000000", "OFFSET 0 0 0")
    motion = formats.read("x.bvh", data=still(text).encode())
    found = motion.skeleton.played()
    assert (found["LToe"], found["RToe"]) == (SIMPLE["LToe"], SIMPLE["RToe"])
    assert motion.warnings == ()


def test_by_shape_too_a_toe_lies_before_the_ankle():
    names = {role: f"J{number}" for number, role in enumerate(SIMPLE)}
    text = hierarchy(names).replace("OFFSET 0.000000 -6.000000 13.000000", "OFFSET 0 -8 0")
    text = text.replace("OFFSET 0.000000 0.000000 6.000000", "OFFSET 0 -1 15")
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert (found["LToe"], found["RToe"]) == (f"{names['LToe']} End", f"{names['RToe']} End")


@pytest.mark.parametrize("above", [10, 16])
@pytest.mark.parametrize("called", ["{role}", "M{number}"])
def test_what_is_called_the_torso_is_the_chest_however_low_it_lies(above: int, called: str):
    names = {role: called.format(role=role, number=n) for n, role in enumerate(SIMPLE)}
    del names["Chest"]
    names |= {"Pelvis": "TORSO#"}
    text = hierarchy(names).replace("000 -4.000000 0.0", f"000 -{above}.000000 0.0")
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert (found["Chest"], found.get("Pelvis")) == ("TORSO#", None)


def test_a_head_without_a_neck_is_the_neck_and_its_tip_the_head():
    names = {role: name for role, name in SIMPLE.items() if role != "Neck"}
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert (found["Neck"], found["Head"]) == ("Head", "Head End")


def test_a_head_in_one_place_with_the_neck_gives_its_tip():
    text = hierarchy().replace(
        "OFFSET 0.000000 10.000000 1.000000", "OFFSET 0.000000 0.000000 0.000000"
    )
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert (found["Neck"], found["Head"]) == ("Head", "Head End")


def test_a_ground_joint_above_the_hips_is_not_the_pelvis():
    names = SIMPLE | {"Pelvis": "Hips"}
    for above in ("joint_Root", "root", "Reference"):
        text = hierarchy(names, above=above)
        motion = formats.read("x.bvh", data=still(text, root=(0, 0, 0, 0, 0, 0)).encode())
        assert motion.skeleton.played()["Pelvis"] == "Hips"
        assert motion.skeleton.names[0] == above


@pytest.mark.parametrize("facing", [0.0, 90.0, 200.0])
@pytest.mark.parametrize("up", ["y", "z"])
def test_shape_alone(facing, up):
    rows = list(SIMPLE)
    names = {role: f"J{rows.index(role) + 1}" for role in rows}
    axes = {"y": ((0, 1), (1, 1), (2, 1)), "z": ((0, 1), (2, -1), (1, 1))}[up]
    turn = (facing, 0, 0) if up == "z" else (0, 0, facing)
    text = still(hierarchy(names, axes=axes), root=(0, 92, 0, *turn))
    motion = formats.read("x.bvh", data=text.encode())
    assert motion.skeleton.played() == played(names)
    assert motion.source.up == up
    assert any("by shape" in warning for warning in motion.warnings)


@examples(30)
@given(st.randoms(use_true_random=False))
def test_shape_does_not_depend_on_the_order_of_sides(numbers: random.Random):
    swap = numbers.random() < 0.5
    roles = [f"J{k}" for k in numbers.sample(range(1000), len(SIMPLE))]
    names = dict(zip(SIMPLE, roles, strict=True))
    text = hierarchy(names)
    if swap:  # the right side first: mirror the text's offsets and the names
        mirrored = {
            role: names[("RL"["LR".index(role[0])] + role[1:]) if role[1:2].isupper() else role]
            for role in names
        }
        text = hierarchy(mirrored, axes=((0, -1), (1, 1), (2, 1)))
    found = formats.read("x.bvh", data=still(text).encode()).skeleton.played()
    assert found == played(names)


def test_arms_missing_from_the_names_are_found_by_shape():
    odd = {role: f"X{k}" for k, role in enumerate(SIMPLE) if role[1:] in ("Shoulder", "Elbow")}
    names = SIMPLE | odd
    motion = formats.read("x.bvh", data=person(names=names))
    assert motion.skeleton.played() == played(names)
    (warning,) = motion.warnings
    assert warning == ("recognised by shape, not by name: RShoulder, RElbow, LShoulder, LElbow")


def test_legs_alone_are_enough():
    legs = ("Pelvis", "Hip", "Knee", "Ankle", "Toe")
    names = {role: name for role, name in SIMPLE.items() if role.lstrip("LR") in legs}
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert set(found) == set(played(names))


def test_arms_and_hips_are_enough():
    names = {r: n for r, n in SIMPLE.items() if r[1:] not in ("Knee", "Ankle", "Toe")}
    found = formats.read("x.bvh", data=person(names=names)).skeleton.played()
    assert {"RHip", "LWrist"} <= found.keys()


def test_what_is_no_human_is_refused_by_name():
    lamp = {"Pelvis": "Base", "Chest": "Stem", "Head": "Bulb"}
    with pytest.raises(BodyError) as caught:
        formats.read("lamp.bvh", data=person(names=lamp))
    text = str(caught.value)
    begun = "lamp.bvh: no human skeleton: among 4 joints (Base, Stem, Bulb, "
    assert text.startswith(begun)
    assert ") there is no RShoulder" in text
    assert "LAnkle" in text


def test_a_near_miss_is_guessed():
    wrong = ("LHip", "RHip", "LWrist", "RWrist")
    names = {
        role: name.replace("Hip", "Hipp_").replace("Wrist", "Wriist")
        for role, name in SIMPLE.items()
        if role in wrong or role[1:] not in ("Collar",)
    }
    data = person(names=names).replace(b" -42.000000 ", b" -4.000000 ")
    data = data.replace(b" -40.000000 ", b" -90.000000 ")
    with pytest.raises(BodyError, match="is 'R"):
        formats.read("x.bvh", data=data)


def test_a_crowd_of_joints_is_refused_quickly():
    crowd = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 }}\n" for k in range(10_000))
    text = hierarchy({"Pelvis": "Hips"}).replace("End Site", crowd + "End Site")
    with pytest.raises(BodyError, match="among 10002 joints"):
        formats.read("crowd.bvh", data=still(text).encode())
    deep = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 " for k in range(5000)) + "}" * 5000
    text = hierarchy({"Pelvis": "Hips"}).replace("End Site", deep + "End Site")
    with pytest.raises(BodyError, match="among 5002 joints"):
        formats.read("deep.bvh", data=still(text).encode())


def test_a_person_in_a_crowd_of_joints_is_found():
    crowd = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 0 }}\n" for k in range(10_000))
    text = hierarchy().replace("JOINT Chest", crowd + "JOINT Chest")
    motion = formats.read("crowd.bvh", data=still(text).encode())
    assert motion.skeleton.played() == played(SIMPLE)


def test_keys():
    names = ("mixamorig:LeftHandMiddle1", "lhumerus", "Bip01 R Thigh", "TORSO#", "hand.R", "RUpLeg")
    assert keys(names) == (
        ("L", "handmiddle1"),
        ("L", "humerus"),
        ("R", "1thigh"),
        ("", "torso"),
        ("R", "hand"),
        ("R", "upleg"),
    )


def test_the_joints_of_a_body_are_in_the_alphabets_order():
    motion = formats.read("x.bvh", data=person())
    assert motion.skeleton.body.dtype == np.int16
    assert [motion.skeleton.names[k] for k in motion.skeleton.body] == list(JOINTS)
