"""Small cases of each stage, made by hand."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from motions import motion_of, swung

from lanindex import read_lnd
from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.encoding import encode
from lanindex.encoding.arithmetic import smooth, window
from lanindex.encoding.direction import Course, Space, course, margins, space
from lanindex.encoding.places import resample
from lanindex.encoding.profile import Rules, load
from lanindex.encoding.timing import quantise, to_source
from lanindex.encoding.written import (
    OUTCOMES,
    Hold,
    Segment,
    achieve,
    apply_rules,
    candidates,
    holds,
    runs,
    segments,
    speeds,
)
from lanindex.model import Meter, Span
from lanindex.model.symbol import blank, joined
from lanindex.notation.lpd_ldd import parse_ldd
from lanindex.perform import perform

RANGES = load("default").ranges["r_arm"]


def cell(name: str) -> int:
    direction, level = name.split()
    return DIRECTION_CODES[direction] * 3 + LEVEL_CODES[level]


def course_of(curve: np.ndarray, around: Space) -> Course:
    return course(curve[None], [around])[0]


def margins_of(curve: np.ndarray, codes: np.ndarray, around: Space) -> tuple[np.ndarray, ...]:
    return margins(curve, codes, [around], np.zeros(len(codes), np.int64))


class TestBody:
    def test_window_is_the_nearest_odd_number(self) -> None:
        assert [window(s, Fraction(60)) for s in (0, 0.01, 0.05, 0.083, 0.15)] == [1, 1, 3, 5, 9]

    def test_average_takes_the_frames_that_exist(self) -> None:
        curve = np.arange(4.0) * np.ones((2, 1))
        assert smooth(curve, 3)[1].tolist() == [0.5, 1.0, 2.0, 2.5]

    def test_a_straight_line_stays_one(self) -> None:
        begin, values = resample(np.arange(10.0)[:, None], 0, Fraction(30), Fraction(60))
        assert begin == 0
        assert values[:, 0] == pytest.approx(np.arange(19) / 2)

    def test_whole_frames_are_kept_exactly(self) -> None:
        points = np.random.default_rng(1).normal(size=(21, 3))
        begin, values = resample(points, 0, Fraction(120), Fraction(60))
        assert begin == 0
        assert np.array_equal(values, points[::2])

    def test_the_heading_has_one_rate_in_every_score(self) -> None:
        motion = motion_of(swung(1, 90, Fraction(30), 0.5), Fraction(30))
        fast = replace(load("default"), rate=Fraction(120))
        plain, fine = encode(motion).heading, encode(motion, fast).heading
        assert len(plain) == 179
        assert np.array_equal(plain, fine)

    def test_no_frame_lies_after_the_last(self) -> None:
        _, values = resample(np.zeros((4, 1)), 0, Fraction(25), Fraction(60))
        assert len(values) == 8  # 3 / 25 s is 7.2 frames of 60

    def test_a_stretch_keeps_the_grid(self) -> None:
        begin, values = resample(np.zeros((5, 1)), 7, Fraction(25), Fraction(60))
        assert (begin, len(values)) == (17, 10)  # 16.8 .. 26.4


class TestDirection:
    @pytest.mark.parametrize("name", ["right mid", "l_back high", "forward low", "place low"])
    def test_references_lie_in_their_cells(self, name: str) -> None:
        around = space(RANGES, 500.0)
        passed = course_of(around.reference(cell(name))[None], around)
        assert passed.cells.tolist() == [cell(name)]
        assert passed.angle[0] == pytest.approx(0, abs=1e-6)
        assert passed.apart[0] == pytest.approx(0, abs=1e-9)

    def test_every_reference_is_its_cells_clearest_point(self) -> None:
        around = space(RANGES, 500.0)
        codes = np.array([code for code in range(24)])
        clear, _ = margins_of(around.references[codes] * 500, codes, around)
        # low and high diagonals stand one radius of place less than 22.5 degrees deep
        assert (clear > 0.8).all()

    def test_borders_begin_the_next_cell(self) -> None:
        around = space(RANGES, 1.0)
        angles = np.radians([22.5, 22.499])
        flat = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
        assert course_of(flat, around).cells.tolist() == [cell("r_forward mid"), cell("right mid")]

    def test_hand_at_the_shoulder_is_place_mid(self) -> None:
        around = space(RANGES, 500.0)
        assert course_of(np.array([[1.0, 0.0, 1.0]]), around).cells.tolist() == [cell("place mid")]

    def test_at_the_joint_itself_is_place_mid(self) -> None:
        around = space(RANGES, 500.0)
        assert course_of(np.zeros((1, 3)), around).cells.tolist() == [cell("place mid")]

    def test_runner_up_lies_across_the_nearest_border(self) -> None:
        around = space(RANGES, 500.0)
        point = np.array([[500 * np.sin(np.radians(20)), 0, 500 * np.cos(np.radians(20))]])
        clear, other = margins_of(point, course_of(point, around).cells, around)
        assert clear[0] == pytest.approx(2.5 / 22.5)
        assert other.tolist() == [cell("r_forward mid")]

    def test_each_limb_has_its_own_division(self) -> None:
        odd = replace(RANGES, starts=tuple((start + 30) % 360 for start in RANGES.starts), mid=20.0)
        curves = np.random.default_rng(2).normal(size=(2, 50, 3)) * 300
        around = [space(RANGES, 500.0), space(odd, 700.0)]
        together = course(curves, around)
        for curve, one, passed in zip(curves, around, together, strict=True):
            alone = course_of(curve, one)
            for name in ("cells", "apart", "angle"):
                assert np.array_equal(getattr(passed, name), getattr(alone, name))
        assert (together[0].cells != course_of(curves[0], around[1]).cells).any()

    def test_margins_come_from_the_limbs_own_division(self) -> None:
        odd = replace(RANGES, starts=tuple((start + 30) % 360 for start in RANGES.starts), mid=20.0)
        points = np.random.default_rng(3).normal(size=(50, 3)) * 300
        around = [space(RANGES, 500.0), space(odd, 700.0)]
        limb = np.arange(50) % 2
        cells = np.choose(limb, [course_of(points, one).cells for one in around])
        clear, other = margins(points, cells, around, limb)
        for index, one in enumerate(around):
            mine = limb == index
            alone = margins_of(points[mine], cells[mine], one)
            assert np.array_equal(clear[mine], alone[0])
            assert np.array_equal(other[mine], alone[1])

    def test_no_radius_of_place_is_no_border(self) -> None:
        around = space(replace(RANGES, place=0.0), 500.0)
        points = np.array([[0.0, -1.0, 0.0], [0.0, -1.0, 500.0]])
        passed = course_of(points, around)
        assert passed.cells.tolist() == [cell("place low"), cell("right mid")]
        clear, other = margins_of(points, passed.cells, around)
        assert clear.tolist() == pytest.approx([1.0, 1.0], abs=0.01)
        assert other[0] == cell("place mid")


class TestSegment:
    def test_ends_are_always_candidates(self) -> None:
        assert candidates(np.array([9.0, 8, 7, 8, 9]), 1.0, 0.0, 0.0).tolist() == [0, 4]

    def test_both_ends_of_a_plateau(self) -> None:
        speed = np.array([9.0, 5, 1, 0.5, 1, 1, 5, 9])
        assert candidates(speed, 6.0, 2.0, 1.0).tolist() == [0, 2, 5, 7]

    def test_shallow_minima_do_not_count(self) -> None:
        speed = np.array([9.0, 4, 4.5, 3, 9])
        assert candidates(speed, 6.0, 1.0, 0.0).tolist() == [0, 3, 4]
        assert candidates(speed, 6.0, 0.5, 0.0).tolist() == [0, 1, 3, 4]

    def test_fast_minima_do_not_count(self) -> None:
        assert candidates(np.array([9.0, 7, 9]), 6.0, 0.0, 0.0).tolist() == [0, 2]

    def test_the_first_frame_may_be_a_minimum(self) -> None:
        assert candidates(np.array([1.0, 9, 9, 1]), 6.0, 0.5, 0.0).tolist() == [0, 3]

    def test_an_end_that_is_lower_outbids_a_stop_before_it(self) -> None:
        speed = np.array([9.0, 4, 4.5, 3.5])
        assert candidates(speed, 6.0, 1.0, 0.0).tolist() == [0, 3]
        assert candidates(speed[:3], 6.0, 1.0, 0.0).tolist() == [0, 1, 2]

    def test_near_candidates_are_one_hold(self) -> None:
        curve = np.array([[0.0, 0, 0], [10, 0, 0], [90, 0, 0], [95, 0, 0]])
        found = holds(curve, np.array([0, 1, 2, 3]), 50.0, 0.0)
        assert found == [Hold(0, 1), Hold(2, 3)]

    def test_out_and_back_is_no_hold(self) -> None:
        curve = np.array([[0.0, 0, 0], [200, 0, 0], [0, 0, 0]])
        assert holds(curve, np.array([0, 2]), 50.0, 0.0) == [Hold(0, 2)]
        assert holds(curve, np.array([0, 2]), 50.0, 100.0) == [Hold(0, 0), Hold(2, 2)]

    def test_the_path_counts_from_the_first_of_a_hold(self) -> None:
        # frame 2 lies 60 from the candidate before it, but 90 or 30 from the hold's first
        for side, found in ((30.0, [Hold(0, 1), Hold(3, 3)]), (-30.0, [Hold(0, 3)])):
            curve = np.array([[0.0, 0, 0], [side, 0, 0], [side + 60, 0, 0], [0, 0, 0]])
            assert holds(curve, np.array([0, 1, 3]), 50.0, 80.0) == found

    def test_a_path_check_below_the_distance_holds_for_candidates_too(self) -> None:
        curve = np.array([[0.0, 0, 0], [10, 0, 0], [30, 0, 0]])
        assert holds(curve, np.array([0, 1, 2]), 50.0, 20.0) == [Hold(0, 1), Hold(2, 2)]

    def test_a_move_begins_where_it_leaves_the_noise(self) -> None:
        speed = np.array([1.0, 1, 1, 1, 1, 1, 1, 1, 50, 100, 50, 1, 1, 1, 1, 1, 1, 1])
        (move,) = segments(speed, [Hold(0, 4), Hold(14, 17)], 0.03, 0.1)
        assert (move.first, move.last, move.begin, move.end) == (4, 14, 7, 11)

    def test_speed_is_a_central_difference(self) -> None:
        curve = np.array([0.0, 1, 4, 9])[:, None] * np.array([1.0, 0, 0])
        assert speeds(curve, 10.0).tolist() == [10, 20, 40, 50]
        assert speeds(curve[:1], 10.0).tolist() == [0]


def cells_of(names: list[str]) -> np.ndarray:
    return np.array([cell(name) for name in names])


def judged(names: list[str], angles: list[float], in_force: str) -> tuple[list[str], np.ndarray]:
    """Return the outcomes of runs before the rules, and their angles."""
    outcome, alive = np.zeros((2, len(names)), np.int64)
    apart, angle = np.array([angles, angles], np.float64)
    achieve(cells_of(names), alive.copy(), apart, angle, cell(in_force), 20, outcome, alive)
    return [OUTCOMES[code] for code in outcome], angle


class TestAchieve:
    def test_a_run_is_achieved_nearest_to_its_reference(self) -> None:
        around = space(RANGES, 500.0)
        angles = np.radians([10, 30, 46, 60, 80, 100])
        curve = 500 * np.stack([0 * angles, -np.cos(angles), np.sin(angles)], axis=1)
        found, *_ = runs(course_of(curve, around), [Segment(0, 5, 0, 5)])
        assert found[:, [0, 3]].tolist() == [
            [cell("place low"), 0],
            [cell("right low"), 2],
            [cell("right mid"), 5],
        ]

    def test_moves_may_share_a_frame_and_begin_amid_a_run(self) -> None:
        cells = np.array([3, 3, 3, 3, 3, 4, 4])
        apart = np.array([0.1, 0.5, 0.4, 0.2, 0.3, 0.2, 0.1])
        moves = [Segment(0, 2, 0, 2), Segment(2, 6, 2, 6)]
        found, *_, counts = runs(Course(cells, apart, 10 * apart), moves)
        assert counts.tolist() == [1, 2]
        assert found[:, 1:].tolist() == [[0, 3, 2], [2, 5, 3], [5, 7, 6]]

    def test_the_first_of_equally_near_frames_counts(self) -> None:
        apart = np.array([0.3, 0.2, 0.2, 0.2, 0.5])
        found, *_ = runs(Course(np.array([3, 3, 3, 3, 4]), apart, apart), [Segment(0, 4, 0, 4)])
        assert found[:, 3].tolist() == [1, 4]

    def test_far_runs_are_dropped_and_neighbours_joined(self) -> None:
        names = ["right mid", "r_forward mid", "right mid", "left mid"]
        outcomes, angle = judged(names, [0, 21, 3, 40], "place low")
        assert outcomes == ["joined", "not achieved", "symbol", "symbol"]
        assert angle[2] == 0

    def test_what_is_in_force_is_no_symbol(self) -> None:
        outcomes, _ = judged(["place low", "right mid"], [0, 0], "place low")
        assert outcomes == ["in force", "symbol"]


class TestRules:
    RULE = "#rule_start#\nL place low\nD right low\nL right mid\n#rule_end#\n"

    def fates(self, names: list[str], in_force: str, text: str) -> np.ndarray:
        found, alive = np.zeros((2, len(names)), np.int64), np.arange(len(names))
        table = Rules(parse_ldd(text)).table
        apply_rules(cells_of(names), cell(in_force), alive, len(names), *table, *found)
        return found

    def outcomes(self, names: list[str], in_force: str, text: str) -> list[str]:
        return [OUTCOMES[code] for code in self.fates(names, in_force, text)[0]]

    def test_the_context_counts(self) -> None:
        assert self.outcomes(["right low", "right mid"], "place low", self.RULE) == [
            "passing",
            "symbol",
        ]
        assert self.outcomes(["right low", "right mid"], "place mid", self.RULE) == ["symbol"] * 2

    def test_the_last_is_never_deleted(self) -> None:
        text = "#rule_start#\nL place low\nD right low\n#rule_end#\n"
        assert self.outcomes(["right low"], "place low", text) == ["symbol"]
        assert self.outcomes(["right low", "left mid"], "place low", text) == ["passing", "symbol"]

    def test_equal_neighbours_that_are_left_become_one(self) -> None:
        text = "#rule_start#\nL right mid\nD right high\nL right mid\n#rule_end#\n"
        names = ["right mid", "right high", "right mid"]
        assert self.outcomes(names, "place low", text) == ["rejoined", "passing", "symbol"]

    def test_rules_apply_until_nothing_matches(self) -> None:
        text = (
            "#rule_start#\nL place low\nD left low\n#rule_end#\n"
            "#rule_start#\nL place low\nD right low\n#rule_end#\n"
        )
        names = ["left low", "right low", "left low", "left mid"]
        assert self.outcomes(names, "place low", text) == ["passing"] * 3 + ["symbol"]

    def test_first_rule_of_the_file_first(self) -> None:
        text = (
            "#rule_start#\nD right low\nL right mid\n#rule_end#\n"
            "#rule_start#\nL right low\nD right mid\nL right high\n#rule_end#\n"
        )
        names = ["right low", "right mid", "right high"]
        assert self.fates(names, "place low", text)[1].tolist() == [1, 0, 0]


def rows(*spans: tuple[int, int], passing: tuple[int, ...] = ()) -> np.ndarray:
    table = blank(len(spans))
    table["start"], table["stop"] = zip(*spans, strict=True)
    table["passing"][list(passing)] = True
    return table


def spans(table: np.ndarray) -> list[tuple[int, int]]:
    return list(zip(table["start"].tolist(), table["stop"].tolist(), strict=True))


def sourced(table: np.ndarray, known: Span, rate: Fraction) -> np.ndarray:
    table = table.copy()
    to_source(table, [len(table)], [known], rate, Fraction(60))
    return table


class TestTiming:
    def test_borders_round_up(self) -> None:
        table = sourced(rows((0, 0), (3, 7), (7, 11)), Span(0, 9), Fraction(30))
        assert spans(table) == [(0, 0), (2, 4), (4, 6)]

    def test_an_empty_symbol_takes_a_frame_of_the_next(self) -> None:
        table = sourced(rows((0, 0), (1, 2), (2, 3), (3, 9)), Span(0, 9), Fraction(30))
        assert spans(table) == [(0, 0), (1, 2), (2, 3), (3, 5)]

    def test_at_the_end_of_the_previous(self) -> None:
        table = sourced(rows((0, 0), (0, 8), (8, 9), (9, 10)), Span(0, 5), Fraction(30))
        assert spans(table) == [(0, 0), (0, 3), (3, 4), (4, 5)]

    def test_too_many_symbols_become_passing(self) -> None:
        table = sourced(rows((0, 0), (0, 8), (8, 16), (16, 24)), Span(0, 2), Fraction(5))
        assert table["passing"].tolist() == [False, True, False, False]
        assert spans(table) == [(0, 0), (0, 1), (0, 1), (1, 2)]

    def test_passing_rows_lie_inside_the_next(self) -> None:
        table = sourced(rows((0, 0), (2, 3), (2, 9), passing=(1,)), Span(0, 9), Fraction(24))
        assert spans(table) == [(0, 0), (1, 2), (1, 4)]

    def test_tracks_at_once_are_what_each_is_by_itself(self) -> None:
        tables = [
            rows((0, 0), (0, 8), (8, 16), (16, 24)),  # too many for its stretch
            rows((9, 9)),
            rows((0, 0), (2, 3), (2, 9), passing=(1,)),
            rows((0, 0), (0, 8), (8, 9), (9, 10)),
        ]
        known = [Span(0, 2), Span(3, 9), Span(0, 9), Span(0, 5)]
        rate = Fraction(24)
        each = [sourced(table, span, rate) for table, span in zip(tables, known, strict=True)]
        together = joined(tables)
        to_source(together, list(map(len, tables)), known, rate, Fraction(60))
        assert together.tolist() == joined(each).tolist()

    def test_tracks_share_a_grid_but_no_room(self) -> None:
        tables = rows((0, 0), (10, 11), (11, 12)), rows((0, 0)), rows((0, 0), (5, 6), (50, 90))
        quantise(tables, 100, Fraction(100), Meter(division=32))
        assert [table["tick"].tolist() for table in tables] == [[0, 1, 2], [0], [0, 0, 4]]
        assert [table["ticks"].tolist() for table in tables] == [[0, 1, 1], [0], [0, 1, 3]]

    def test_quantised_symbols_neither_overlap_nor_vanish(self) -> None:
        table = rows((0, 0), (10, 11), (11, 12), (12, 13), (50, 100))
        meter = quantise([table], 100, Fraction(100), Meter(division=32))
        assert meter.division == 32
        assert table["tick"].tolist() == [0, 1, 2, 3, 4]
        assert table["ticks"].tolist() == [0, 1, 1, 1, 4]

    def test_the_grid_is_refined_where_there_is_no_room(self) -> None:
        table = rows((0, 0), *((90 + k, 91 + k) for k in range(10)))
        meter = quantise([table], 100, Fraction(100), Meter(division=32))
        assert meter.division == 512
        assert (np.diff(table["tick"][1:]) >= 1).all()
        assert table["tick"][-1] + table["ticks"][-1] <= 128


@pytest.mark.parametrize(("sway", "swings"), [(0, 0), (15, 0), (30, 1), (60, 9)])
def test_a_raise_that_is_held_has_no_swings_and_the_smallest_wave_has(sway, swings):
    lines = "r_arm place low 0 0", "r_arm right high 1 2", "r_arm place low 6 7"
    score = "#unit1\n" + "".join(f"direction {it}\n" for it in lines)
    held = perform(read_lnd(score), rate=30)
    places, time = held.positions.copy(), np.arange(len(held)) / 30
    hand = held.skeleton.names.index("RightHand")
    places[:, hand, 2] += sway * np.sin(2 * np.pi * time) * ((time > 2) & (time < 6))
    symbols = encode(replace(held, positions=places)).symbols("r_arm")
    assert [it.swings for it in symbols if it.level == "high"] == [swings]
