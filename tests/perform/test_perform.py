from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from effort import examples
from hypothesis import assume, given
from hypothesis import strategies as st
from random_scores import scores

from lanindex.alphabet import JOINT_CODES, PARTS
from lanindex.errors import UsageError
from lanindex.model import Motion, Score
from lanindex.notation import lnd
from lanindex.perform import perform
from lanindex.perform.limbs import great_circle, minimum_jerk, standard
from lanindex.perform.stage import LONGEST


def act(*lines: str, rate: Fraction | int = 60, **options: float) -> Motion:
    """Perform a score at one beat a second; lines of unit 0 come first, behind them unit 1's."""
    text = ["#speed=60"]
    for line in lines:
        text += ["#unit0" if line.endswith(" 0 0") else "#unit1", f"direction {line}"]
    return perform(lnd.read("\n".join(text)), rate=rate, **options)


def seen(motion: Motion, part: str, seconds: float) -> np.ndarray:
    """Return child minus parent of a part: right, up, forward as the performer has them."""
    frame = min(round(seconds * float(motion.rate)), len(motion) - 1)
    joints = motion.positions[frame, motion.skeleton.body]
    left, up, front = (
        joints[JOINT_CODES[PARTS[part].child]] - joints[JOINT_CODES[PARTS[part].parent]]
    )
    return np.array([-left, up, front])


def pointing(motion: Motion, part: str, seconds: float) -> np.ndarray:
    way = seen(motion, part, seconds)
    return way / np.linalg.norm(way)


HALF = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("words", "way"),
    [
        ("place low", [0, -1, 0]),
        ("place high", [0, 1, 0]),
        ("right mid", [1, 0, 0]),
        ("left mid", [-1, 0, 0]),
        ("forward mid", [0, 0, 1]),
        ("back low", [0, -HALF, -HALF]),
        ("right high", [HALF, HALF, 0]),
        ("l_forward mid", [-HALF, 0, HALF]),
        ("r_back high", [0.5, HALF, -0.5]),
    ],
)
@pytest.mark.parametrize("part", ["r_arm", "l_arm", "r_leg", "l_thigh", "head", "torso", "r_hand"])
def test_right_is_right(part: str, words: str, way: list[float]) -> None:
    motion = act(f"{part} {words} 0 1")
    assert pointing(motion, part, 2) == pytest.approx(way, abs=1e-3)


@pytest.mark.parametrize("part", [part for part in PARTS if PARTS[part].group != "palm"])
def test_every_part_starts_where_it_is_told(part: str) -> None:
    motion = act(f"{part} l_back high 0 0")
    assert pointing(motion, part, 0) == pytest.approx([-0.5, HALF, -0.5], abs=1e-3)
    assert pointing(motion, part, 4) == pytest.approx([-0.5, HALF, -0.5], abs=1e-3)


def test_a_body_starts_with_the_twist_and_the_lean_it_is_told() -> None:
    starts = "#unit0\ntwist torso_twist left 45 0 0\nincline head_incline forward 30 0 0\n"
    motion = perform(lnd.read(f"#speed=60\n{starts}#unit1\ndirection r_arm right mid 1 2"))
    first, second, still = motion.positions[[0, 1, 30]]
    assert np.allclose(first, still, atol=1e-6)
    assert np.allclose(second, still, atol=1e-6)
    assert abs(pointing(motion, "head", 0)[2]) > 0.3


def test_the_performer_faces_forward_and_stands_on_the_floor() -> None:
    motion = act("r_arm right mid 0 1")
    joints = dict(zip(motion.skeleton.names, motion.positions[0], strict=True))
    assert joints["LeftUpLeg"][0] > joints["RightUpLeg"][0]
    assert joints["LeftToeBase"][2] > joints["LeftFoot"][2]
    assert joints["Head End"][1] == pytest.approx(1750, abs=1)
    assert motion.positions[..., 1].min() > 0


def test_limbs_are_straight_unless_told() -> None:
    motion = act("r_arm right high 0 1")
    for part in ("r_upper_arm", "r_forearm", "r_hand"):
        assert pointing(motion, part, 0.5) == pytest.approx(
            pointing(motion, "r_arm", 0.5), abs=1e-3
        )


def test_the_bone_knows_better_than_its_limb() -> None:
    motion = act("r_arm right mid 0 1", "r_forearm place high 0 1", "l_thigh forward mid 0 1")
    assert pointing(motion, "r_upper_arm", 2) == pytest.approx([1, 0, 0], abs=1e-3)
    assert pointing(motion, "r_forearm", 2) == pytest.approx([0, 1, 0], abs=1e-3)
    assert pointing(motion, "l_shank", 2) == pytest.approx([0, 0, 1], abs=1e-3)
    bent = act("l_thigh forward mid 0 1", "l_shank place low 0 0")
    assert pointing(bent, "l_shank", 2) == pytest.approx([0, -1, 0], abs=1e-3)


def test_what_hangs_on_the_torso_moves_with_it() -> None:
    motion = act("torso forward mid 0 1")
    assert pointing(motion, "head", 2) == pytest.approx([0, 0, 1], abs=1e-3)
    assert pointing(motion, "r_arm", 2) == pytest.approx([0, -1, 0], abs=1e-3)
    joints = motion.positions[120, motion.skeleton.body]
    shoulder, neck = joints[JOINT_CODES["RShoulder"]], joints[JOINT_CODES["Neck"]]
    assert shoulder - neck == pytest.approx([-185, 0, -40], abs=0.1)


@pytest.mark.parametrize("side", "rl")
def test_place_mid_brings_the_hand_to_the_shoulder(side: str) -> None:
    motion = act(f"{side}_arm place mid 1 2", f"{side}_arm forward mid 3 4")
    out = 1 if side == "r" else -1
    across, up, front = seen(motion, f"{side}_arm", 2.5)
    assert np.hypot(across, front) < 60
    assert abs(up) < 1
    elbow = seen(motion, f"{side}_upper_arm", 2.5)
    assert elbow[1] < -200
    assert elbow[0] * out > 150
    for part in ("upper_arm", "forearm"):
        assert np.linalg.norm(seen(motion, f"{side}_{part}", 1.6)) == pytest.approx(285, abs=0.1)
    steps = np.linalg.norm(np.diff(motion.positions, axis=0), axis=2)
    assert steps.max() < 90  # no jump: a leap of the elbow would be 300


def test_one_bone_cannot_fold() -> None:
    motion = act("r_forearm right mid 0 1", "r_forearm place mid 1 2")
    assert motion.warnings == (
        "r_forearm is one bone and cannot come to place mid: it stays where it is",
    )
    assert pointing(motion, "r_forearm", 3) == pytest.approx([1, 0, 0], abs=1e-3)


def test_strange_parts_are_told() -> None:
    assert act("tail back low 0 1").warnings == ("the standard body has no tail",)


@pytest.mark.parametrize(
    ("start", "stop", "middle"),
    [
        ("place low", "place high", [0, 0, 1]),
        ("left mid", "right mid", [0, 0, 1]),
        ("forward mid", "back mid", [1, 0, 0]),
        ("r_forward mid", "l_back mid", [-HALF, 0, HALF]),
    ],
)
def test_half_turns_pass_in_front(start: str, stop: str, middle: list[float]) -> None:
    motion = act(f"r_arm {start} 0 0", f"r_arm {stop} 0 2")
    assert pointing(motion, "r_arm", 1) == pytest.approx(middle, abs=1e-3)


def test_half_turns_to_the_back_pass_the_own_side() -> None:
    motion = act("l_arm back mid 0 0", "l_arm forward mid 0 2")
    assert pointing(motion, "l_arm", 1) == pytest.approx([-1, 0, 0], abs=1e-3)


WAYS = (
    st.lists(st.floats(-1, 1), min_size=3, max_size=3)
    .map(np.array)
    .filter(lambda way: np.linalg.norm(way) > 0.1)
)


@given(WAYS, WAYS)
def test_great_circles(start: np.ndarray, stop: np.ndarray) -> None:
    start, stop = start / np.linalg.norm(start), stop / np.linalg.norm(stop)
    share = np.linspace(0, 1, 9)
    points = great_circle(start, stop, share, np.array([0.0, 0.0, 1.0]))
    assert np.linalg.norm(points, axis=1) == pytest.approx(1)
    assert points[0] == pytest.approx(start)
    assert points[-1] == pytest.approx(stop, abs=1e-6)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps == pytest.approx(steps[0], abs=1e-9)
    assert 2 * np.arcsin(steps[0] / 2) * 8 <= np.pi + 1e-6


def test_a_reach_starts_and_ends_in_its_frames() -> None:
    motion = act("r_arm right mid 1 2", rate=50)
    moved = np.linalg.norm(
        np.diff(motion.positions[:, motion.skeleton.body[8 - 2]], axis=0), axis=1
    )
    assert np.flatnonzero(moved > 1e-3).tolist() == list(range(50, 100))
    assert pointing(motion, "r_arm", 1.5) == pytest.approx([HALF, -HALF, 0], abs=1e-3)


def test_minimum_jerk_starts_and_ends_at_rest() -> None:
    share = np.linspace(0, 1, 1001)
    speed = np.gradient(minimum_jerk(share), share)
    assert speed[[0, -1]] == pytest.approx([0, 0], abs=1e-4)
    assert speed.max() == pytest.approx(1.875, abs=1e-4)


@given(scores(), st.fractions(1, 50, max_denominator=1001))
@examples(25)
def test_any_score_at_any_rate(score: Score, rate: Fraction) -> None:
    assume(score.frames * rate / score.rate <= LONGEST)  # more is refused
    motion = perform(score, rate=rate)
    assert motion.rate == rate
    assert len(motion) == -(-score.frames * rate // score.rate)
    assert np.isfinite(motion.positions).all()
    offsets = np.linalg.norm(motion.skeleton.offsets, axis=1)
    bones = motion.positions[:, 1:] - motion.positions[:, motion.skeleton.parents[1:]]
    assert np.abs(np.linalg.norm(bones, axis=2) - offsets[1:]).max() < 0.01


def test_noise_is_seeded_and_as_large_as_told() -> None:
    still, one, same, two = (
        act("r_arm right mid 0 1", noise=noise, seed=seed)
        for noise, seed in ((0, 0), (2, 1), (2, 1), (2, 2))
    )
    assert (one.positions == same.positions).all()
    assert (one.positions != two.positions).any()
    error = (one.positions - still.positions)[:, still.skeleton.body]
    assert error.std(axis=(0, 1)) == pytest.approx([2, 2, 2], rel=0.05)
    assert abs(np.corrcoef(error[:, 7, 0], error[:, 8, 0])[0, 1]) < 0.2


@pytest.mark.parametrize("options", [{"rate": 0}, {"rate": -30}, {"noise": -1}, {"noise": np.nan}])
def test_nonsense_is_refused(options: dict[str, float]) -> None:
    with pytest.raises(UsageError):
        act("r_arm right mid 0 1", **options)


def test_a_score_too_long_is_refused() -> None:
    with pytest.raises(UsageError, match="at most 100000"):
        perform(lnd.read("#unit_total 1000\n#unit1\ndirection r_arm right mid 0 1"))


def test_a_performance_has_60_frames_a_second_unless_told() -> None:
    score = lnd.read("#unit_total 1\n#unit1\ndirection r_arm right mid 0 1")
    motion = perform(score)
    assert (motion.rate, len(motion)) == (60, 240)
    assert len(perform(score, rate=30)) == 120


def test_the_standard_body_hangs_on_one_root() -> None:
    parents = standard().skeleton.parents.tolist()
    assert parents[0] == -1
    assert all(0 <= parent < joint for joint, parent in enumerate(parents) if joint)


def test_an_elbow_never_leaps():
    text = "#unit0\ndirection l_arm left mid 0 0\n#unit1\nbend l_arm_bend bend4 0 1\n"
    for ways in permutations(
        ("forward mid", "place low", "left high", "right mid", "place high"), 2
    ):
        lines = (f"direction l_arm {way} {it + 1} {it + 2}\n" for it, way in enumerate(ways))
        motion = perform(lnd.read(text + "".join(lines)), rate=60)
        elbow, shoulder = (motion.skeleton.names.index(f"Left{it}") for it in ("ForeArm", "Arm"))
        arm = motion.positions[:, elbow] - motion.positions[:, shoulder]
        assert np.linalg.norm(np.diff(arm, axis=0), axis=1).max() < 45, ways


def test_feet_turn_with_a_body_that_stands() -> None:
    """A half turn after steps leaves no crossed legs, and the next steps go on from there."""
    text = (
        "#speed=60\n#unit0\nsupport r_support place mid 0 0\nsupport l_support place mid 0 0\n"
        "#unit1\nsupport r_support forward mid 1 2\nsupport l_support place mid 2 3\n"
        "rotation body_turn left 180 4 6\n"
    )
    for steps in ("", "support r_support forward mid 7 8\nsupport l_support place mid 8 9\n"):
        motion = perform(lnd.read(text + steps), rate=60)
        joints = motion.positions[:, motion.skeleton.body]
        across = [
            joints[:, JOINT_CODES[f"R{name}"]] - joints[:, JOINT_CODES[f"L{name}"]]
            for name in ("Hip", "Ankle")
        ]
        hips, feet = (
            one[200:400, ::2] / np.linalg.norm(one[200:400, ::2], axis=1)[:, None] for one in across
        )
        assert (hips * feet).sum(axis=1).min() > 0.99
        assert np.linalg.norm(across[1][-1] - across[0][-1]) < 5
