"""Motions with unknown joints, unclear headings or parts without length."""

from fractions import Fraction

import numpy as np
import pytest
from motions import motion_of, swung

from lanindex.alphabet import ALWAYS, DIRECTION_CODES, JOINT_CODES, LEVEL_CODES, PARTS
from lanindex.encoding import encode, joints, trace
from lanindex.encoding.direction import space
from lanindex.encoding.limbs import heading
from lanindex.encoding.profile import load
from lanindex.encoding.written import ROW, write_rows
from lanindex.errors import EncodeError
from lanindex.model import Motion

RATE = Fraction(60)
PROFILE = load("default")


def changed(body: np.ndarray, joint: str, frames: slice, place: object) -> np.ndarray:
    other = body.copy()
    other[frames, JOINT_CODES[joint]] = place
    return other


def rows(motion: Motion) -> dict[str, tuple[object, bytes]]:
    score = encode(motion)
    return {part: (track.known, track.symbols.tobytes()) for part, track in score.tracks.items()}


@pytest.mark.parametrize("odd", [np.inf, -np.inf, (0.0, np.inf, 0.0)])
@pytest.mark.parametrize("frames", [slice(30, 33), slice(30, 80)])
def test_infinite_is_unknown(odd: object, frames: slice) -> None:
    body = swung(1, 120, RATE, 0.0)
    holed = rows(motion_of(changed(body, "RWrist", frames, np.nan), RATE))
    assert rows(motion_of(changed(body, "RWrist", frames, odd), RATE)) == holed


class TestHeading:
    def body(self) -> np.ndarray:
        body = np.zeros((9, 20, 3))
        body[:, JOINT_CODES["RHip"]] = (0.0, 900.0, 100.0)
        return body

    def test_where_it_is_unclear_the_last_turn_is_kept_and_at_the_start_the_first(self) -> None:
        body = changed(self.body(), "RHip", slice(0, 3), (0.0, 900.0, 0.9))
        body = changed(body, "RHip", slice(3, 5), (100.0, 900.0, 0.0))
        body = changed(body, "RHip", slice(6, 8), (0.0, 900.0, -0.9))
        turn = np.degrees(heading(motion_of(body, RATE), RATE))
        assert turn == pytest.approx([90, 90, 90, 90, 90, 0, 0, 0, 0])

    def test_a_millimetre_tells(self) -> None:
        body = changed(self.body(), "RHip", slice(4, 9), (1.0, 900.0, 0.0))
        turn = np.degrees(heading(motion_of(body, RATE), RATE))
        assert turn == pytest.approx([0] * 4 + [90] * 5)

    def test_hips_above_each_other_for_ever_tell_nothing(self) -> None:
        body = changed(self.body(), "RHip", slice(None), (0.5, 900.0, 0.0))
        assert heading(motion_of(body, RATE), RATE).tolist() == [0.0] * 9

    def test_shoulders_stand_in_for_hips(self) -> None:
        body = changed(self.body(), "RHip", slice(None), np.nan)
        body = changed(body, "RShoulder", slice(None), (100.0, 1400.0, 0.0))
        turn = np.degrees(heading(motion_of(body, RATE), RATE))
        assert turn == pytest.approx([90] * 9)


class TestLimbs:
    def test_a_limb_of_no_length_is_no_part(self) -> None:
        body = swung(2, 90, RATE, 0.0)
        body[:, JOINT_CODES["RHand"]] = body[:, JOINT_CODES["RWrist"]]
        score = encode(motion_of(body, RATE))
        assert "r_hand" not in score.tracks
        assert len(PARTS.keys() & score.tracks) == len(ALWAYS) - 1

    def test_a_limb_whose_length_was_never_seen_is_told(self) -> None:
        body = swung(2, 90, RATE, 0.0)
        body[:45, JOINT_CODES["RElbow"]] = np.nan
        body[45:, JOINT_CODES["RWrist"]] = np.nan
        score = encode(motion_of(body, RATE))
        assert "r_arm" not in score.tracks
        told = "r_arm is left out: how long it is was never seen"
        assert told in score.warnings
        assert not any("l_arm" in warning for warning in score.warnings)

    def test_nothing_but_limbs_of_no_length_is_refused(self) -> None:
        with pytest.raises(EncodeError, match="no part of the body is known"):
            encode(motion_of(np.ones((9, 20, 3)), RATE))

    def test_no_frames_are_refused(self) -> None:
        with pytest.raises(EncodeError, match="no frames, wanted one at least"):
            encode(motion_of(np.zeros((0, 20, 3)), RATE))

    def test_one_frame_has_starting_positions(self) -> None:
        score = encode(motion_of(swung(3, 1, RATE, 0.0), RATE))
        assert {len(score.tracks[part]) for part in ALWAYS} == {1}

    def test_a_part_that_nobody_knows_is_refused(self) -> None:
        with pytest.raises(EncodeError, match='no part "r_tail" is known'):
            trace(motion_of(swung(3, 9, RATE, 0.0), RATE), "r_tail")

    def test_the_length_goes_through_the_elbow_if_it_is_ever_seen(self) -> None:
        body = np.zeros((9, 20, 3))
        body[:, JOINT_CODES["RElbow"]] = (0.0, 300.0, 0.0)
        body[:, JOINT_CODES["RWrist"]] = (0.0, 300.0, 400.0)
        for frames, length in ((slice(1, 9), 700.0), (slice(None), 500.0)):
            motion = motion_of(changed(body, "RElbow", frames, np.nan), RATE)
            assert joints.Body(motion, load("default")).lengths(["r_arm"]).tolist() == [length]

    def test_a_missing_pelvis_is_the_middle_of_the_hips(self) -> None:
        body = swung(4, 50, RATE, 0.0)
        body[7, JOINT_CODES["LHip"], 0] = np.inf
        without = motion_of(changed(body, "Pelvis", slice(None), np.nan), RATE)
        hips = body[:, [JOINT_CODES["LHip"], JOINT_CODES["RHip"]]]
        hips[7, 0] = np.nan
        found = joints.body(without)["Pelvis"]
        assert np.array_equal(np.delete(found, 7, axis=0), np.delete(hips.mean(axis=1), 7, axis=0))
        assert found[7] == pytest.approx((found[6] + found[8]) / 2)  # a gap that is filled

    def test_a_calibration_pose_is_replaced_before_gaps_are_filled(self) -> None:
        body = changed(swung(5, 50, RATE, 0.0), "RWrist", slice(0, 1), np.nan)
        found = joints.body(motion_of(body, RATE, first=1))
        assert np.array_equal(found.places[0], found.places[1])
        alone = joints.body(motion_of(body[:1], RATE, first=1))  # nothing to stand in
        assert np.array_equal(alone.places, body[:1], equal_nan=True)


def rows_of(
    curve: np.ndarray, middles: np.ndarray, moves: list[tuple[int, ...]], cells: list[int]
) -> np.ndarray:
    """Return the rows of moves that pass one cell each, in which they arrive in the last frame."""
    apart, angle = np.zeros((2, len(moves)))
    outcome, deleted = np.zeros((2, len(moves)), np.int64)
    of_runs = np.array(cells), np.array([last for _, last, *_ in moves]), apart, angle
    told = 20.0, 50.0, middles, len(moves) > 1, *PROFILE.rules["r_arm"].table
    table = np.array([(*move, 1) for move in moves])
    return write_rows(curve.T, 0, table, *of_runs, outcome, deleted, *told).view(ROW)[:, 0]


class TestSwings:
    @pytest.mark.parametrize(("apart", "swings"), [(49.999, 0), (50.0, 1), (90.0, 1)])
    def test_a_move_without_a_symbol_counts_from_d_t_on(self, apart: float, swings: int) -> None:
        curve = np.array([[0.0, -500.0, 0.0], [apart, -500.0, 0.0]])
        found = rows_of(curve, np.zeros((27, 3)), [(0, 1, 0, 1)], [0])
        assert found["swings"].tolist() == [swings]


class TestLengthening:
    """Stage 2b: a move without a symbol may begin the next one, if it touches and heads for it."""

    CELL = DIRECTION_CODES["forward"] * 3 + LEVEL_CODES["mid"]

    def started(self, curve: np.ndarray, middle: np.ndarray, gap: int = 0) -> int:
        middles = np.zeros((27, 3))
        middles[self.CELL] = middle
        moves = [(0, 1, 10, 20), (2, 3, 21 + gap, 40)]
        return int(rows_of(curve, middles, moves, [0, self.CELL])["start"][1])

    def begin(self, gap: int, share: float) -> int:
        # a first move of 100 mm that comes nearer to "forward mid" by `share` of it, then another
        around = space(PROFILE.ranges["r_arm"], 1000.0)
        middle = around.reference(self.CELL)
        curve = np.array([(500.0, 0, 0), (500.0 + 100 * share, 0, 0), middle, middle])
        if share < 1:  # the rest of the way leads round the middle
            radius = 500.0 - 100 * share
            turn = np.arccos((500.0**2 + radius**2 - 100**2) / (2 * 500 * radius))
            curve[1] = middle - radius * np.array([np.cos(turn), 0, np.sin(turn)])
        return self.started(curve, middle, gap)

    def test_a_move_that_touches_begins_the_next_symbol(self) -> None:
        assert self.begin(gap=0, share=1.0) == 10
        assert self.begin(gap=1, share=1.0) == 22

    def test_it_has_to_head_for_it_by_half_its_length(self) -> None:
        assert self.begin(gap=0, share=0.51) == 10
        assert self.begin(gap=0, share=0.49) == 21

    def test_it_has_to_head_for_the_middle_of_the_cell_not_for_where_it_ends(self) -> None:
        curve = np.array([(500.0, 0, -300), (500.0, 0, 0), (500.0, 0, 0), (900.0, 0, 300)])
        middle = space(PROFILE.ranges["r_arm"], 1000.0).reference(self.CELL)
        assert self.started(curve, middle) == 21

    def test_by_exactly_half_is_enough(self) -> None:
        middle = np.array([50.0, 0.0, 0.0])
        # from 125 mm to 75 mm before the middle, 100 mm of way aside
        curve = np.array([(-75.0, 0, 0), (-25.0, 0, 0), middle, middle])
        assert self.started(curve, middle) == 10
        curve = np.array([(50.0, 0, 80), (110.0, 0, 0), middle, middle])  # 100 mm, 20 nearer
        assert self.started(curve, middle) == 21
        curve = np.array([(50.0, 0, 80), (20.0, 0, 0), middle, middle])
        assert self.started(curve, middle) == 10


def test_a_trace_prints_its_moves_frame_by_frame() -> None:
    found = trace(motion_of(swung(8, 120, RATE, 0.0), RATE), "r_arm")[0]
    text = str(found)
    assert f"r_arm: length {found.space.length:.0f} mm, 120 frames" in text
    for move, runs in zip(found.segments, found.runs, strict=True):
        assert f"\n  move {move.first}-{move.last}, seen {move.begin}-{move.end}" in text
        assert all(f"\n    {run.start}-{run.stop - 1} " in text for run in runs)
