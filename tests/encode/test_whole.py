"""Bodies that step, jump and turn by plan are encoded as planned."""

import tracemalloc
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from effort import thinned
from motions import LEG, Do, walk

import lanindex
from lanindex import compiled, encode
from lanindex.alphabet import DIRECTIONS, JOINT_CODES, MOST_AMOUNT
from lanindex.encoding.ground import grounds
from lanindex.encoding.joints import Body
from lanindex.encoding.limbs import heading
from lanindex.encoding.profile import load
from lanindex.encoding.steps import BOTH_BOTH, BOTH_ONE, HOP, LEAP, ONE_BOTH
from lanindex.encoding.whole import _ways, whole
from lanindex.model import Motion, Score

STEPS = ["r", "l", "r", "l"]
UP = np.array([0, 1, 0], np.float32)


def said(score: Score, part: str) -> list[str]:
    """Return what the rows of a part say, starting positions left out."""
    return [symbol.words for symbol in score.symbols(part) if symbol.start < symbol.stop]


def times(score: Score, part: str) -> list[tuple[int, int]]:
    return [(it.start, it.stop) for it in score.symbols(part) if it.start < it.stop]


def going(way: str, size: float = 0.5, **how) -> Motion:
    steps = [Do(foot, way, size, **how) for foot in STEPS]
    return walk([Do("stand", bent=how.get("bent", 0.0)), *steps, Do("stand", **how)])


def close(found: list[int], wanted: list[int], most: int) -> bool:
    return len(found) == len(wanted) and np.abs(np.subtract(found, wanted)).max(initial=0) <= most


@pytest.mark.parametrize("way", DIRECTIONS)
def test_steps_in_every_direction(way):
    score = encode(going(way, 0.0 if way == "place" else 0.5))
    assert said(score, "step") == [f"{way} mid"] * 4
    assert said(score, "r_support") == said(score, "l_support") == [f"{way} mid"] * 2
    assert close([stop for _, stop in times(score, "step")], [61, 91, 121, 151], 3)
    assert score.tracks["step"].kind == "step"


def test_steps_follow_one_another_without_a_hole():
    found = times(encode(going("forward")), "step")
    assert all(one[1] == two[0] for one, two in pairwise(found))


@pytest.mark.parametrize("drift", [0.12, 0.4])
def test_steps_are_found_where_the_floor_rises_under_the_feet(drift):
    steps = [Do(foot, "forward", 0.5) for foot in STEPS]
    motion = walk([Do("stand", seconds=2), *steps, *steps, Do("stand")])
    rise = drift * LEG * np.clip(np.arange(len(motion)) / 60 - 1, 0, 1)
    floats = replace(motion, positions=motion.positions + np.float32(rise)[:, None, None] * UP)
    assert said(encode(floats), "step") == ["forward mid"] * 8


def test_a_foot_that_always_stands_a_little_higher_carries_too():
    motion = going("forward")
    places = motion.positions.copy()
    for joint in ("RAnkle", "RToe"):
        places[:, motion.skeleton.body[JOINT_CODES[joint]], 1] += 0.07 * LEG
    scores = encode(replace(motion, positions=places)), encode(motion)
    assert close(*(np.ravel(times(it, "r_stance")) for it in scores), 1)


def test_a_step_of_a_foot_that_was_held_begins_behind_the_hold():
    motion = walk([Do("stand"), Do("r", "forward", 0.5), Do("stand")])
    frames = np.repeat(np.arange(len(motion)), np.where(np.arange(len(motion)) == 45, 120, 1))
    held = encode(replace(motion, positions=motion.positions[frames]))
    (step,) = times(held, "step")
    assert close([*step], [165, 181], 6)


def test_a_step_after_a_rest_begins_as_the_foot_leaves():
    score = encode(walk([Do("r", "forward", 0.5), Do("stand", seconds=2), Do("l", "forward", 0.5),
                         Do("stand")]))  # fmt: skip
    (_, first), (second, _) = times(score, "step")
    assert first <= 32
    assert 146 <= second <= 154


@pytest.mark.parametrize(
    ("how", "level"), [({"bent": 0.3}, "low"), ({}, "mid"), ({"toes": True}, "high")]
)
def test_the_level_of_a_step_is_how_the_leg_takes_the_weight(how, level):
    assert said(encode(going("forward", **how)), "step") == [f"forward {level}"] * 4


@pytest.mark.parametrize(
    ("feet", "amount"),
    [("rl>rl", BOTH_BOTH), ("r>r", HOP), ("r>l", LEAP), ("r>rl", ONE_BOTH), ("rl>l", BOTH_ONE)],
)
def test_the_five_kinds_of_jumps(feet, amount):
    before = [] if feet.startswith("rl") else [Do("jump", feet="rl>r", seconds=0.3)]
    still = [Do("stand", seconds=0.4)] if before else []
    jump = Do("jump", "forward", 0.6, 0.35, feet=feet)
    score = encode(walk([Do("stand"), *before, *still, jump, Do("stand", seconds=0.7)]))
    symbol = score.symbols("jump")[-1]
    assert (symbol.direction, symbol.amount) == ("forward", amount)
    start = 31 + 18 * bool(before) + 24 * bool(still)
    assert close([symbol.start, symbol.stop], [start, start + 21], 3)
    steps = {"leap": 1, "both": 1}.get("leap" if amount == LEAP else "", 0)
    assert len(said(score, "step")) == steps + bool(before) + (amount == BOTH_ONE)


def test_a_body_that_stands_or_waves_a_leg_does_not_jump():
    score = encode(walk([Do("stand", seconds=3)]))
    assert said(score, "jump") == said(score, "step") == said(score, "r_support") == []
    assert said(score, "body_travel") == ["place"]
    assert [symbol.words for symbol in score.symbols("r_support")] == ["place mid"]


def test_what_hangs_in_the_air_for_long_does_not_jump():
    motion = walk([Do("stand"), Do("jump", seconds=0.5), Do("stand")])
    places = motion.positions.copy()
    up = places[:, :, 1] - places[0, :, 1]
    places[:, :, 1] -= 0.9 * up  # as if it were a tenth as heavy
    hung = Motion(motion.skeleton, motion.rate, places, motion.source)
    assert len(said(encode(motion), "jump")) == 1
    assert said(encode(hung), "jump") == []


@pytest.mark.parametrize("degrees", [45, 90, -90, 135, -180, 360, -720])
def test_turns_by_steps(degrees):
    count = max(abs(degrees) // 45, 1)
    steps = [Do("rl"[it % 2], turn=degrees / count) for it in range(count)]
    score = encode(walk([Do("stand", seconds=1), *steps, Do("stand", seconds=1)]))
    (turn,) = score.symbols("body_turn")
    assert turn.direction == ("left" if degrees > 0 else "right")
    assert abs(turn.amount - abs(degrees)) <= 2
    assert close([turn.start, turn.stop], [61, 61 + 30 * count], 15)


def swaying(motion: Motion, phase: float) -> Motion:
    """Return a walk of steps of half a second with hips and shoulders that sway, in degrees."""
    places = motion.positions.astype(float)
    angle = np.radians(np.sin(2 * np.pi * np.arange(len(motion)) / float(motion.rate) + phase))
    for joint, degrees in (("Hip", 12), ("Shoulder", -8)):
        left, right = (motion.skeleton.body[JOINT_CODES[side + joint]] for side in "LR")
        half = (places[:, right] - places[:, left])[:, ::2] @ (0.5, 0.5j)
        swayed = half * (np.exp(1j * degrees * angle) - 1)
        for side, way in ((right, swayed), (left, -swayed)):
            places[:, side, 0] += way.real
            places[:, side, 2] += way.imag
    return replace(motion, positions=places.astype(np.float32))


@pytest.mark.parametrize(
    ("rate", "goes", "degrees"),
    thinned(
        (
            (rate, goes, degrees)
            for rate, goes in ((30, True), (60, False), (120, True))
            for degrees in (90, -90, 180, -180, 360, -360)
        ),
        4,
    ),
)
def test_turns_of_bodies_that_sway(rate, goes, degrees):
    walks = [Do("rl"[it % 2], "forward", 0.6) for it in range(6)] if goes else [Do("stand")] * 3
    turn = [Do("stand", seconds=abs(degrees) / 150, turn=degrees)]
    if goes:
        turn = [Do(foot, "forward", 0.4, turn=degrees / 4) for foot in STEPS]
    for phase in (0.0, 2.0, 4.0):
        (told,) = encode(swaying(walk(walks + turn + walks, rate), phase)).symbols("body_turn")
        assert told.direction == ("left" if degrees > 0 else "right")
        assert abs(told.amount - abs(degrees)) <= 5


@pytest.mark.parametrize("lost", [slice(50, None), slice(0, 130), slice(80, 110), slice(None)])
def test_who_turns_while_the_shoulders_are_lost_turns(lost):
    rest, steps = Do("stand", seconds=1), [Do("rl"[it % 2], turn=45) for it in range(2)]
    motion = walk([rest, *steps, rest])
    places = motion.positions.copy()
    for side in "LR":
        places[lost, motion.skeleton.body[JOINT_CODES[f"{side}Shoulder"]]] = np.nan
    assert said(encode(replace(motion, positions=places)), "body_turn") == ["left 90deg"]


def test_two_turns_with_a_rest_between_are_two():
    turn, rest = [Do("r", turn=45), Do("l", turn=45)], Do("stand", seconds=1.5)
    score = encode(walk([rest, *turn, rest, *turn, rest]))
    assert said(score, "body_turn") == ["left 90deg", "left 90deg"]


def test_the_sway_of_a_walk_is_no_turn():
    sway = [Do("rl"[it % 2], "forward", 0.6, turn=12 * (-1) ** it) for it in range(12)]
    score = encode(walk(sway))
    assert said(score, "body_turn") == []
    (way,) = score.symbols("body_travel")
    assert way.direction == "forward"
    assert way.amount < 15


@pytest.mark.parametrize(("turn", "least", "most"), [(0, 0, 3), (15, 130, 200)])
def test_a_way_is_straight_or_circles(turn, least, most):
    circle = [Do("rl"[it % 2], "forward", 0.6, turn=turn) for it in range(12)]
    (way,) = encode(walk(circle)).symbols("body_travel")
    assert way.direction == "forward"
    assert least <= way.amount <= most


def test_who_turns_a_hundred_times_turns_as_often_as_can_be_told():
    turns = encode(walk([Do("r", turn=40_000, seconds=200), Do("stand")])).symbols("body_turn")
    assert [it.amount for it in turns] == [MOST_AMOUNT]


@pytest.mark.parametrize("way", DIRECTIONS[:8])
def test_travel(way):
    score = encode(walk([Do("stand", seconds=2), *[Do(foot, way, 0.6) for foot in 3 * STEPS],
                         Do("stand", seconds=2)]))  # fmt: skip
    assert said(score, "body_travel") == ["place", way, "place"]
    (_, first), (_, second), (_, last) = times(score, "body_travel")
    assert close([first, second, last], [121, 481, score.frames], 25)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ((85, 62, 85, 61), [(0, 2)]),  # degrees; forward lies between 67.5 and 112.5
        ((80, 62, 60, 62), [(0, 1)]),  # together they lie across the border
        ((85, 59, 85), [(0, 2), (1, 1), (2, 2)]),
        ((85, None, 62), [(0, 2), (1, 8), (2, 1)]),
    ],
)
def test_a_way_that_sways_about_a_border_has_one_direction(path, said):
    parts = [
        (number, 8 if way is None else round(way / 45), np.sin(away), np.cos(away))
        for number, way in enumerate(path)
        for away in [np.radians(way or 0)]
    ]
    assert [it[:2] for it in _ways(parts)] == said


@pytest.mark.parametrize(("turn", "beside"), [(10, "r_forward"), (-10, "l_forward")])
def test_who_does_not_quite_go_as_he_faces_is_told_by_what_is_across_the_border(turn, beside):
    motion = going("forward")
    angle = np.radians(turn)  # the hips turn to the left, the way stays
    places = motion.positions.copy()
    middle = places[:, [JOINT_CODES["RHip"], JOINT_CODES["LHip"]]].mean(axis=1, keepdims=True)
    x, _, z = np.moveaxis(places - middle, 2, 0)
    places[..., 0] = middle[..., 0] + x * np.cos(angle) + z * np.sin(angle)
    places[..., 2] = middle[..., 2] + z * np.cos(angle) - x * np.sin(angle)
    way = encode(replace(motion, positions=places)).symbols("body_travel")[0]
    assert (way.direction, way.runner_direction) == ("forward", beside)
    assert way.margin == pytest.approx(1 - 10 / 22.5, abs=0.05)


def test_a_way_is_seen_from_the_chest_and_steps_from_the_hips():
    motion = going("forward")
    places, shoulders = motion.positions.copy(), [JOINT_CODES[f"{it}Shoulder"] for it in "RL"]
    middle = places[:, shoulders].mean(axis=1)
    half = (places[:, shoulders[0]] - places[:, shoulders[1]]) / 2
    half = half[:, [2, 1, 0]] * (-1, 1, 1)  # a quarter turn to the right
    places[:, shoulders] = np.stack((middle + half, middle - half), axis=1)
    score = encode(replace(motion, positions=places))
    assert {it.direction for it in score.symbols("body_travel")} - {"place"} == {"left"}
    assert set(said(score, "step")) == set(said(encode(motion), "step"))


def test_stairs_are_climbed_with_a_word():
    motion = going("forward")
    places = motion.positions.copy()
    climbed = np.maximum.accumulate(places[:, 0, 0]) * 0.5
    places[:, :, 1] += climbed[:, None].astype(np.float32)
    moved = Motion(motion.skeleton, motion.rate, places, motion.source)
    (found,) = grounds(Body(moved, load("default")), LEG)
    assert found.doubts


@pytest.mark.parametrize("missing", ["RAnkle", "RHip"])
def test_without_a_foot_or_a_hip_there_is_no_support(missing):
    from lanindex.alphabet import JOINT_CODES

    motion = going("forward")
    places = motion.positions.copy()
    places[:, JOINT_CODES[missing]] = np.nan
    score = encode(Motion(motion.skeleton, motion.rate, places, motion.source))
    assert not {"step", "jump", "r_support", "l_support"} & score.tracks.keys()


def test_a_gap_parts_the_tracks():
    from lanindex.alphabet import JOINT_CODES

    motion = going("forward")
    places = motion.positions.copy()
    places[70:90, JOINT_CODES["LAnkle"]] = np.nan
    score = encode(Motion(motion.skeleton, motion.rate, places, motion.source))
    assert [(it.start, it.stop) for it in score.tracks["step"].known] == [(0, 70), (90, 181)]
    assert [(it.start, it.stop) for it in score.tracks["body_turn"].known] == [(0, 181)]


@pytest.mark.parametrize("rate", [24, 30, 120])
def test_the_rate_changes_nothing(rate):
    does = [Do("stand"), *[Do(foot, "forward", 0.6) for foot in STEPS],
            Do("jump", seconds=0.4), Do("stand", seconds=1), Do("r", turn=90)]  # fmt: skip
    ours, other = encode(walk(does)), encode(walk(does, rate))
    for part in ("step", "jump", "body_turn", "body_travel", "r_support", "l_support"):
        assert said(ours, part)[:1] == said(other, part)[:1]
        assert len(said(ours, part)) == len(said(other, part)), part
        seconds = [
            [border / float(score.rate) for pair in times(score, part) for border in pair]
            for score in (ours, other)
        ]
        assert np.abs(np.subtract(*seconds)).max(initial=0) < 0.08, part


def test_noise_changes_little():
    does = [Do("stand"), *[Do(foot, "forward", 0.6) for foot in 2 * STEPS],
            Do("jump", seconds=0.4), Do("stand", seconds=1)]  # fmt: skip
    motion = walk(does)
    noise = np.random.default_rng(1).normal(0, 2, motion.positions.shape).astype(np.float32)
    shaken = Motion(motion.skeleton, motion.rate, motion.positions + noise, motion.source)
    for part in ("step", "jump", "body_turn"):
        assert said(encode(motion), part) == said(encode(shaken), part)
    (way, place), (again, _) = (said(encode(it), "body_travel") for it in (motion, shaken))
    assert (way, place) == ("forward", "place")
    assert again in ("forward", *(f"forward {degrees}deg" for degrees in range(15)))


def test_the_length_of_the_leg_is_what_things_are_measured_in():
    small = walk([Do("stand"), *[Do(foot, "forward", 0.6) for foot in STEPS], Do("jump")])
    grown = Motion(small.skeleton, small.rate, small.positions * 2, small.source)
    for part in ("step", "jump", "body_travel", "r_support"):
        assert said(encode(small), part) == said(encode(grown), part)
        assert times(encode(small), part) == times(encode(grown), part)
    assert LEG > 0


def test_one_frame_and_none_to_stand_on():
    motion = walk([Do("stand")])
    for frames in (1, 2, 3):
        cut = Motion(motion.skeleton, Fraction(60), motion.positions[:frames], motion.source)
        score = encode(cut)
        assert said(score, "step") == said(score, "jump") == said(score, "body_turn") == []
        assert said(score, "body_travel") == ["place"]


@pytest.mark.slow
def test_memory_grows_by_little_a_frame(monkeypatch):
    monkeypatch.setattr(compiled, "chosen", lambda name, size: False)  # numba itself takes 30 MB
    motion = going("forward")
    turns, frames = heading(motion, motion.rate), 60_000
    times = frames // len(motion)
    long = replace(motion, positions=np.tile(motion.positions, (times, 1, 1)))
    tracemalloc.start()
    try:
        whole(Body(long, load("default")), np.tile(turns, times))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 450 * len(long)


@pytest.mark.parametrize(("way", "flies"), [("place", False), ("forward", True)])
def test_who_runs_may_sink_slower_in_the_air(way, flies):
    motion = walk([Do("stand"), Do("jump", way, 1.2, seconds=0.4), Do("stand")])
    places = motion.positions.copy()
    up = places[:, :, 1] - places[0, :, 1]
    places[:, :, 1] -= (1 - 5 / 12) * up  # as if it fell with 5 legs a second squared
    assert bool(said(encode(replace(motion, positions=places)), "jump")) == flies


def test_a_short_run_goes_as_fast_as_it_does():
    motion = going("forward")
    some = slice(64, 88)  # of a step
    score = encode(replace(motion, positions=motion.positions[some]))
    assert said(score, "body_travel") == ["forward"]


def test_a_foot_holds_weight_from_its_step_until_it_leaves():
    score = encode(going("forward"))
    right, left = (times(score, f"{side}_stance") for side in "rl")
    assert [len(right), len(left)] == [3, 3]
    assert right[0][0] == left[0][0] == 0
    ends = [stop for _, stop in times(score, "r_support")]
    assert close([start for start, _ in right[1:]], ends, 1)
    assert close([start for start, _ in left[1:]], [91, 151], 3)
    assert right[-1][1] == left[-1][1] == score.frames
    low = encode(going("forward", bent=0.35))
    assert said(low, "r_stance")[1:] == ["low", "low"]


def test_feet_that_slide_apart_together_neither_jump_nor_step():
    score = encode(lanindex.read("corpus/jumping_jacks.bvh"))
    assert said(score, "jump") == said(score, "step") == []
    assert times(score, "r_support")[1:] == times(score, "l_support")[1:]
    assert len(said(score, "r_support")) == 14
