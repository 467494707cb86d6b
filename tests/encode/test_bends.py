"""Bends of elbows and knees: synthetic angles, random scores, captures."""

from dataclasses import replace
from fractions import Fraction

import motions
import numpy as np
import pytest
from random_bends import RATE, drawn, said

from lanindex import encode, read, read_lnd, write_lnd
from lanindex.alphabet import BENDS, JOINT_CODES
from lanindex.encoding.profile import load
from lanindex.model import Motion, Score, Skeleton, Source, Span
from lanindex.model.derived import with_bends
from lanindex.notation.excerpt import excerpt
from lanindex.perform import perform

CHAIN = ("RShoulder", "RElbow", "RWrist")


def arm(angles, rate: int = 60, upper: float = 300.0, lower: float = 250.0) -> Motion:
    """Return an arm that hangs and is bent forward by angles, frame by frame, degrees."""
    turn = np.radians(np.asarray(angles, float))
    places = np.zeros((len(turn), 3, 3))
    places[:, 1, 1] = -upper
    places[:, 2] = places[:, 1]
    places[:, 2, 1] -= lower * np.cos(turn)
    places[:, 2, 2] = lower * np.sin(turn)
    body = np.full(len(JOINT_CODES), -1, np.int16)
    body[[JOINT_CODES[name] for name in CHAIN]] = range(3)
    skeleton = Skeleton(CHAIN, np.array([-1, 0, 1], np.int16), np.zeros((3, 3), np.float32), body)
    source = Source("", "made", "mm", 1.0, "y")
    return Motion(skeleton, Fraction(rate), places.astype(np.float32), source)


def bends(motion: Motion) -> list[str]:
    return [str(it).removeprefix("r_arm_bend ") for it in encode(motion).symbols("r_arm_bend")]


def ways(*knots: tuple[int, float]) -> np.ndarray:
    """Return angles that go straight on between frames."""
    frames, angles = zip(*knots, strict=True)
    return np.interp(np.arange(frames[-1] + 1), frames, angles)


def amounts(score: Score, part: str = "r_arm_bend") -> list[str]:
    return said(score, part)


@pytest.mark.parametrize("degree", range(7))
def test_a_degree_is_a_sixth_of_a_half_turn(degree):
    assert bends(arm([30 * degree] * 60)) == [f"bend{degree} [0, 0)"]
    near = 30 * degree + (14 if degree < 6 else -14)
    assert bends(arm([near] * 60)) == [f"bend{degree} [0, 0)"]


def test_it_begins_and_arrives():
    found = encode(arm(ways((0, 0), (60, 0), (90, 90), (150, 90), (210, 30), (300, 30))))
    first, bend, stretch = found.symbols("r_arm_bend")
    assert (first.words, bend.words, stretch.words) == ("bend0", "bend3", "stretch1")
    for symbol, start, stop in ((bend, 60, 90), (stretch, 150, 210)):
        assert abs(symbol.start - start) <= 6
        assert abs(symbol.stop - stop) <= 6
    assert bend.margin > 0.9


def test_how_long_the_bones_are_is_all_the_same():
    angles = ways((0, 10), (30, 10), (60, 130), (120, 130))
    assert bends(arm(angles)) == bends(arm(angles, upper=150, lower=600))


def test_an_elbow_at_a_border_does_not_flicker():
    waves = 75 + 9 * np.sin(np.arange(600) / 9)
    assert len(bends(arm(waves))) == 1
    to_there = np.concatenate((ways((0, 60), (60, 60), (90, 75)), waves))
    assert amounts(encode(arm(to_there))) == ["bend3"]


def test_what_sways_is_no_bend():
    assert len(bends(arm(30 + 9 * np.sin(np.arange(600) / 20)))) == 1
    assert len(bends(arm(60 + 25 * np.sin(np.arange(600) / 20)))) > 5


def test_a_rest_parts_two_bends():
    angles = ways((0, 0), (60, 0), (90, 60), (120, 60), (150, 120), (210, 120))
    assert amounts(encode(arm(angles))) == ["bend2", "bend4"]
    angles = ways((0, 0), (60, 0), (90, 60), (96, 60), (126, 120), (210, 120))
    assert amounts(encode(arm(angles))) == ["bend4"]


def test_where_a_joint_gives_way_another_bend_begins():
    angles = ways((0, 0), (30, 0), (45, 28), (75, 12), (90, 85), (120, 85))
    assert amounts(encode(arm(angles))) == ["bend1", "bend3"]


def test_what_is_slow_is_not_lost():
    assert amounts(encode(arm(ways((0, 0), (600, 100), (660, 100))))) == ["bend3"]


def test_who_has_no_elbow_does_not_bend():
    whole = arm(ways((0, 0), (60, 90)))
    body = whole.skeleton.body.copy()
    body[JOINT_CODES["RElbow"]] = -1
    score = encode(replace(whole, skeleton=replace(whole.skeleton, body=body)))
    assert list(score.tracks) == ["r_arm"]
    assert {it.amount for it in score.symbols("r_arm")} == {None}


def test_an_elbow_that_is_lost_for_a_while():
    motion = arm(ways((0, 0), (60, 0), (90, 90), (400, 90)))
    places = motion.positions.copy()
    places[150:250, 1] = np.nan
    score = encode(replace(motion, positions=places))
    track = score.tracks["r_arm_bend"]
    assert track.known == (Span(0, 150), Span(250, 401))
    assert [it.words for it in track.listed()] == ["bend0", "bend3", "bend3"]


@pytest.mark.parametrize(("noise", "most"), [(0.0, 2), (2.0, 3)])
def test_what_is_carried_out_comes_back(noise, most):
    wanted, off = 0, []
    for seed in range(4):
        score = drawn(seed)
        found = encode(perform(score, rate=RATE, noise=noise, seed=seed))
        for part in BENDS.values():
            assert said(found, part) == said(score, part)
            for one, two in zip(score.symbols(part)[1:], found.symbols(part)[1:], strict=True):
                wanted += 1
                off += [abs(one.start - two.start), abs(one.stop - two.stop)]
    assert wanted == 4 * 4 * 12
    assert np.percentile(off, 95) <= most


def test_a_squat_sinks_and_keeps_its_feet():
    text = "#unit0\nsupport r_support place mid 0 0\nsupport l_support place mid 0 0\n#unit1\n" + (
        "".join(
            f"bend {side}_leg_bend bend4 1 2\nbend {side}_leg_bend stretch0 2.5 3.5\n"
            for side in "rl"
        )
    )
    text += "#unit2\nsupport r_support forward mid 1 2\n"
    motion = perform(read_lnd(text), rate=RATE)
    found = encode(motion)
    for part in ("r_leg_bend", "l_leg_bend"):
        assert said(found, part)[:2] == ["bend4", "stretch0"]
    feet = [motion.skeleton.names.index(name) for name in ("RightFoot", "LeftFoot")]
    assert np.ptp(motion.positions[: 4 * RATE, feet], axis=0).max() < 5
    assert motion.positions[130, 0, 1] < 0.65 * motion.positions[0, 0, 1]


def test_a_free_leg_is_bent_as_told():
    text = (
        "#unit0\nsupport r_support place mid 0 0\nsupport l_support place mid 0 0\n#unit1\n"
        "support r_support forward mid 0 1\nbend r_leg_bend bend3 0 0.5\n"
        "bend r_leg_bend stretch0 0.5 1\nsupport l_support forward mid 1 2\n"
    )
    found = encode(perform(read_lnd(text), rate=RATE))
    assert said(found, "r_leg_bend")[:2] == ["bend3", "stretch0"]
    assert [it.words for it in found.symbols("step")] == ["forward mid"] * 2


def test_the_field_goes_through_lnd():
    for seed in range(3):
        score = drawn(seed)
        text = write_lnd(score)
        there = read_lnd(text)
        assert write_lnd(there) == text
        assert {limb for limb in there.tracks if limb in BENDS} == {"r_arm", "l_arm"}
        for limb in ("r_arm", "l_arm"):
            told = [it.amount for it in there.symbols(limb)]
            assert None not in told
            assert told == [it.amount for it in read_lnd(write_lnd(there)).symbols(limb)]


def test_a_gesture_is_as_bent_as_the_last_bend_that_was_half_done():
    score = read_lnd(
        "#unit0\ndirection r_arm place low 0 0\nbend r_arm_bend bend0 0 0\n#unit1\n"
        "bend r_arm_bend bend4 0 2\ndirection r_arm forward mid 0 0.5\n"
        "direction r_arm right mid 0.5 1\ndirection r_arm left mid 1 3\n"
    )
    assert [it.amount for it in score.symbols("r_arm")] == [0, 0, 4, 4]
    assert [it.words for it in score.symbols("r_arm")][1:3] == ["forward mid", "right mid bent 4"]
    assert all(it.amount is None for it in with_bends({"r_arm": score.tracks["r_arm"]})["r_arm"]
               .listed())  # fmt: skip
    cut = excerpt(score, Span(16, 32))
    assert [it.words for it in cut.symbols("r_arm_bend")] == ["bend4"]
    assert {it.amount for it in cut.symbols("r_arm")} == {4}


@pytest.mark.parametrize("path", ["kick", "punch", "guide"])
def test_real_captures_turned_mirrored_and_scaled(captures, path):
    motion = read(captures / f"bvh/bandai1/dataset-1_{path}_normal_001.bvh")
    profile = load("default")
    whole = {part: bends_of(encode(motion, profile), part) for part in BENDS.values()}
    for other in (motions.turned(motion, 37), motions.scaled(motion, 2.5)):
        assert {it: bends_of(encode(other, profile), it) for it in whole} == whole
    image = encode(motions.mirrored(motion), profile)
    for part, own in whole.items():
        assert bends_of(image, {"r": "l", "l": "r"}[part[0]] + part[1:]) == own


def bends_of(score: Score, part: str) -> list[str]:
    return [str(it).split(" ", 1)[1] for it in score.symbols(part)]


def test_what_one_sees_in_real_captures(captures):
    def of(name: str, part: str) -> list[str]:
        score = encode(read(captures / f"bvh/bandai1/dataset-1_{name}_normal_001.bvh"))
        return said(score, part)

    assert of("punch", "l_arm_bend")[:5] == ["stretch0", "bend4", "stretch0", "bend4", "stretch0"]
    assert of("bow", "r_arm_bend") == of("bow", "l_arm_bend") == ["bend3", "stretch1"]
    assert of("bow", "r_leg_bend") == []
    assert of("kick", "r_leg_bend")[:2] == ["bend3", "stretch0"]
