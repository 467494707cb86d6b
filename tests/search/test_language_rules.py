"""Rules of the language beyond the cases of the page."""

from fractions import Fraction

import pytest
from plain_matcher import find
from query_cases import recordings_of, track

from lanindex.errors import UsageError
from lanindex.model import Capture, Meter, Span, Track
from lanindex.model.symbol import blank
from lanindex.search.language import parse


def found(tracks: str, pattern: str, **options) -> list[tuple[int, int]]:
    """Return the spans of a pattern in ``r_arm: place low 0 0, …; …`` of 100 frames at 10 fps."""
    (recording,) = recordings_of(f"fps 10 frames 100; {tracks}")
    hits = find(parse(pattern), [(recording.capture, recording.tracks)], **options)
    return [(hit.span.start, hit.span.stop) for hit in hits]


GAP = "place low 0 0, right high 10 20, place low 50 50, right high 60 70, right mid 70 80"


def with_a_gap(pattern: str, **parts: str) -> list[tuple[int, int]]:
    """Return the spans where the right arm is not known from 30 to 50, and after 90."""
    capture = Capture(1, "gap", "lnd", "0" * 64, "", Fraction(10), 100, Meter())
    tracks = {"r_arm": track("r_arm", GAP, 100, (Span(0, 30), Span(50, 90)))}
    tracks |= {part: track(part, text, 100) for part, text in parts.items()}
    hits = find(parse(pattern), [(capture, tracks)], overlaps="all")
    return [(hit.span.start, hit.span.stop) for hit in hits]


class TestGaps:
    def test_no_arrow_crosses_one(self):
        assert with_a_gap("r_arm high ... high") == []
        assert with_a_gap("r_arm high ... mid") == [(60, 80)]
        assert with_a_gap("r_arm low -> high") == [(0, 20), (50, 70)]
        assert with_a_gap("r_arm low ... mid") == [(50, 80)]

    def test_no_stay_and_no_rest_crosses_one(self):
        assert with_a_gap("r_arm hold") == [(0, 10), (20, 30), (50, 60), (80, 90)]
        assert with_a_gap("r_arm at high") == [(19, 30), (69, 70)]
        assert with_a_gap("r_arm at any") == [(0, 30), (50, 90)]

    def test_the_first_position_after_one_is_no_movement(self):
        assert with_a_gap("r_arm low") == []
        assert with_a_gap("r_arm rising") == [(10, 20), (60, 70)]

    def test_the_clip_starts_and_ends_but_once(self):
        assert with_a_gap("start -> r_arm high") == [(10, 20)]
        assert with_a_gap("start ... r_arm high") == [(10, 20)]
        assert with_a_gap("r_arm mid -> end") == []
        assert with_a_gap("l_arm high -> end", l_arm="place low 0 0, left high 5 9") == [(5, 9)]

    def test_no_arrow_to_another_part_crosses_one(self):
        left = "place low 0 0, left high 5 9, left mid 35 40, left high 55 58"
        assert with_a_gap("l_arm high -> r_arm high", l_arm=left) == [(5, 20), (55, 70)]
        assert with_a_gap("l_arm mid -> r_arm high", l_arm=left) == []
        assert with_a_gap("l_arm mid ... r_arm high", l_arm=left) == []


class TestStartingPosition:
    def test_it_begins_a_line_that_goes_on(self):
        arm = "r_arm: right high 0 0, place low 5 9"
        assert found(arm, "r_arm high") == []
        assert found(arm, "r_arm high -> hold") == [(0, 5)]
        assert found(arm, "r_arm high -> mid?") == []
        assert found(arm, "r_arm high -> low?") == [(0, 9)]
        assert found(arm, "r_arm high -> end") == []
        assert found(arm, "(r_arm high) -> low") == [(0, 9)]

    def test_it_has_no_length(self):
        arm = "r_arm: right high 0 0, place low 5 9"
        for length in ("<1s", "0s..9s", "0f", ">=0s"):
            assert found(arm, f"r_arm high {length} -> low") == []
            assert found(arm, f"(r_arm high) {length} -> low") == []
        assert found(arm, "(r_arm high -> low) 0.9s") == [(0, 9)]

    def test_it_lasts_until_the_first_movement_for_sharing_frames(self):
        arms = "r_arm: place low 0 0, right high 8 9; l_arm: left mid 0 0, place low 3 5"
        assert found(arms, "arms low -> hold") == [(0, 8)]
        assert found(arms, "(r_arm low with l_arm mid) -> high") == [(0, 9)]
        late = "r_arm: place low 0 0, right high 8 9; l_arm: left mid 0 0, place low 8 9"
        assert found(late, "arms low -> high") == []

    def test_it_is_there_in_the_first_frame_even_if_all_moves_from_there_on(self):
        arms = "r_arm: place low 0 0, right high 0 9; l_arm: place low 0 0, left high 0 8"
        assert found(arms, "arms low -> high") == [(0, 9)]
        assert found(arms, "arms at low") == []

    def test_a_line_beside_takes_it_only_beside_another(self):
        arms = "r_arm: place low 0 0, right high 4 9, place low 10 12; l_arm: place low 0 0"
        assert found(arms, "(r_arm low with l_arm low) -> high") == [(0, 9)]
        assert found(arms, "(r_arm high with l_arm low) -> low") == []
        assert found(arms, "(r_arm high with l_arm at low) -> low") == [(0, 100)]

    def test_the_first_movement_may_come_without_one(self):
        arm = "r_arm: right high 5 9, place low 20 30"
        assert found(arm, "start -> r_arm high") == [(5, 9)]
        assert found(arm, "r_arm rising") == []
        assert found(arm, "r_arm hold") == [(9, 20), (30, 100)]


class TestArrows:
    ARM = (
        "r_arm: place low 0 0, right mid 10 20, right high 30 40, right mid 40 50, place low 60 70"
    )

    def test_a_step_left_out_takes_the_arrow_before_it_along(self):
        assert found(self.ARM, "r_arm mid -> place high? ...[<0.5s] low") == []
        assert found(self.ARM, "r_arm mid ->[<0.5s] place high? ...[1s] low") == [(40, 70)]
        assert found(self.ARM, "r_arm place high? ...[<0.5s] low") == [(60, 70)]
        assert found(self.ARM, "start ...[<2s] r_arm left? -> mid") == [(10, 20)]
        assert found(self.ARM, "r_arm low -> left? ->[<1s] end") == []

    def test_time_passes_behind_a_passing_symbol_unless_the_next_one_follows(self):
        arm = "r_arm: place low 0 0, right low* 5 8, right mid 5 20, place high 30 40"
        for limit, hit in (("<2s", []), ("2.2s..2.2s", [(0, 40)])):
            assert found(arm, f"r_arm low -> right low ...[{limit}] high") == hit
        assert found(arm, "r_arm low -> right low ->[0f] right mid") == [(0, 20)]
        assert found(arm, "r_arm low -> right low ...[0f] right mid") == [(0, 20)]

    def test_a_rest_follows_its_own_movement_only(self):
        assert found(self.ARM, "r_arm high -> hold") == []
        assert found(self.ARM, "r_arm high ... hold") == [(30, 60)]
        assert found(self.ARM, "r_arm high ...[0] hold") == []
        assert found(self.ARM, "r_arm high ...[1] hold") == [(30, 60)]
        assert found(self.ARM, "r_arm hold -> hold") == []
        assert found(self.ARM, "r_arm at mid -> hold") == []

    def test_a_stay_follows_with_its_first_movement(self):
        assert found(self.ARM, "r_arm low -> at mid/high") == [(0, 60)]
        assert found(self.ARM, "r_arm mid -> at mid/high") == []
        assert found(self.ARM, "r_arm mid -> at high -> at mid") == [(10, 60)]

    def test_from_start_to_end(self):
        assert found(self.ARM, "start -> r_arm any ...[3] end") == [(10, 20)]
        assert found(self.ARM, "start -> r_arm any x4 -> end") == [(10, 70)]
        assert found(self.ARM, "start ->[1s] r_arm any x1+ ->[3s] end") == [(10, 70)]
        assert found(self.ARM, "start ...[2] r_arm mid") == [(40, 50)]
        assert found(self.ARM, "start -> r_arm hold -> any") == [(0, 20)]
        assert found(self.ARM, "start ...[1] r_arm at mid") == [(19, 30)]

    def test_another_part_s_first_stay_or_rest(self):
        arms = self.ARM + "; l_arm: place low 0 0, left mid 5 15, left high 25 35, left low 45 50"
        assert found(arms, "r_arm high -> l_arm hold") == [(30, 100)]
        assert found(arms, "r_arm mid -> l_arm hold mid") == []
        assert found(arms, "r_arm mid ...[1] l_arm hold") == [(10, 100)]
        assert found(arms, "r_arm mid -> l_arm at high") == [(10, 45)]
        assert found(arms, "l_arm mid -> r_arm high") == [(5, 40)]
        assert found(arms, "l_arm mid -> arms low") == []
        assert found(arms, "l_arm high -> arms low") == []
        assert found(arms, "r_arm low -> l_arm mid -> arms high") == [(0, 40)]


class TestTwoTogether:
    ARMS = (
        "r_arm: place low 0 0, right mid 10 20, right high 30 40, place low 60 70; "
        "l_arm: place low 0 0, left mid 12 22, left high 22 40, left mid 40 50, place low 62 72"
    )

    def test_each_arm_has_its_own_next_movement(self):
        assert found(self.ARMS, "arms mid -> high") == [(10, 40)]
        assert found(self.ARMS, "arms high -> low") == []
        assert found(self.ARMS, "arms high ...[<=1] low") == [(22, 72)]
        assert found(self.ARMS, "arms high ...[1] low") == []
        assert found(self.ARMS, "arms rising x2") == [(10, 40)]

    def test_staying_and_resting_is_while_both_do(self):
        assert found(self.ARMS, "arms at high") == [(39, 40)]
        assert found(self.ARMS, "arms high -> hold") == []
        assert found(self.ARMS, "arms hold 1s+") == [(0, 10), (50, 60), (72, 100)]

    def test_a_pair_ends_with_the_later_one(self):
        assert found(self.ARMS, "arms mid ->[0s] high") == [(10, 40)]
        assert found(self.ARMS, "arms mid 1.2s") == [(10, 22)]
        assert found(self.ARMS, "(arms mid -> high) 3s") == [(10, 40)]

    def test_one_first_symbol_a_pair(self):
        arms = (
            "r_arm: place low 0 0, right mid 10 40; "
            "l_arm: place low 0 0, left mid 5 15, left mid 20 30, left mid 35 45"
        )
        assert found(arms, "arms mid", overlaps="all") == [(5, 40), (10, 40), (10, 45)]

    def test_one_arm_is_not_two(self):
        assert found("r_arm: place low 0 0, right mid 10 20", "arms mid") == []
        assert found("r_arm: place low 0 0, right mid 10 20", "arm mid") == [(10, 20)]


class TestSides:
    ARMS = (
        "r_arm: place low 0 0, right mid 10 20, left mid 30 40; "
        "l_arm: place low 0 0, left mid 50 60, right high 70 80"
    )

    def test_the_same_one_along_the_line(self):
        assert found(self.ARMS, "arm side -> across") == [(10, 40), (50, 80)]
        assert found(self.ARMS, "arm mid -> arm high") == [(50, 80)]
        assert found(self.ARMS, "arm mid -> (arm mid)") == [(10, 40)]
        assert found(self.ARMS, "(arm mid -> across or arm side) -> end") == [(10, 40), (50, 80)]
        assert found(self.ARMS, "arm not side") == [(30, 40), (70, 80)]

    def test_another_line_is_free_to_be_the_other_one(self):
        both = "r_arm: place low 0 0, right mid 10 20; l_arm: place low 0 0, left high 10 20"
        assert found(both, "arm mid with arm high") == [(10, 20)]
        assert found(both, "arm mid with arm mid") == []

    def test_a_part_carried_into_a_mirror_stays(self):
        assert found(self.ARMS, "r_arm right -> mirror(right)") == [(10, 40)]
        assert found(self.ARMS, "r_arm right -> mirror(l_arm right)") == [(10, 40)]
        assert found(self.ARMS, "mirror(r_arm right -> left)") == [(50, 80)]
        assert found(self.ARMS, "mirror(arm side -> across)") == [(10, 40), (50, 80)]


class TestBrackets:
    ARMS = (
        "r_arm: place low 0 0, right high 10 20, right mid 24 30; "
        "l_arm: place low 0 0, left high 5 22, place low 40 50; head: forward mid 0 0, left mid 6 8"
    )

    def test_one_stands_as_its_own_first_line(self):
        assert found(self.ARMS, "(r_arm high with l_arm high) ->[0.4s] mid") == [(5, 30)]
        assert found(self.ARMS, "(r_arm high with l_arm high) 1s") == [(5, 22)]
        assert found(self.ARMS, "(r_arm high with l_arm high) 1.7s") == []
        assert found(self.ARMS, "(l_arm high with r_arm high) 1.7s -> low") == [(5, 50)]

    def test_one_of_a_single_step_in_the_middle_of_a_line(self):
        assert found(self.ARMS, "r_arm low -> (high) 1s -> mid") == [(0, 30)]
        assert found(self.ARMS, "r_arm low -> (high) <1s -> mid") == []
        arms = "r_arm: place low 0 0, right high 4 9, right mid 12 20; l_arm: place low 0 0"
        assert found(arms, "r_arm low -> (high with l_arm low) -> mid") == []

    def test_without_looks_at_the_whole_bracket(self):
        assert found(self.ARMS, "r_arm high without head") == [(10, 20)]
        assert found(self.ARMS, "r_arm high with l_arm high without head") == []
        assert found(self.ARMS, "r_arm low -> (high without head) -> mid") == [(0, 30)]
        assert found(self.ARMS, "r_arm low -> high -> mid without head") == []
        assert found(self.ARMS, "(r_arm high during l_arm high) without head") == [(10, 20)]

    def test_the_place_of_a_line_beside_does_not_matter(self):
        assert found(self.ARMS, "r_arm high without head with l_arm high") == []


class TestAsLongAsItCan:
    ARMS = (
        "r_arm: place low 0 0, right mid 10 20, left mid 20 30, right mid 30 40, left mid 40 50; "
        "head: forward mid 0 0, left mid 35 38"
    )

    def test_a_repeat_that_ends_a_line(self):
        assert found(self.ARMS, "r_arm mid x1+") == [(10, 50)]
        assert found(self.ARMS, "r_arm mid x2..3") == [(10, 40)]
        assert found(self.ARMS, "(r_arm mid x1+)") == [(10, 50)]
        assert found(self.ARMS, "(r_arm mid x1+ with r_arm at low)") == []
        assert found(self.ARMS, "r_arm low -> (right -> left) x1+") == [(0, 50)]
        assert found(self.ARMS, "r_arm low ... left x1+") == [(0, 30)]

    def test_one_that_does_not_end_a_line_ends_as_early_as_it_can(self):
        assert found(self.ARMS, "r_arm mid x1+ -> left") == [(10, 30), (30, 50)]
        assert found(self.ARMS, "r_arm mid x0+ -> left", overlaps="all") == [
            *((10, 30), (20, 30), (30, 50), (40, 50))
        ]

    def test_as_long_as_the_whole_pattern_lets_it(self):
        assert found(self.ARMS, "r_arm mid x1+ without head") == [(10, 30), (40, 50)]
        assert found(self.ARMS, "(r_arm mid x1+) <3s") == [(10, 30), (30, 50)]
        assert found(self.ARMS, "r_arm mid x1+ with head") == [(10, 50)]

    def test_lines_beside_run_on_too(self):
        assert found(self.ARMS, "head with r_arm mid x1+") == [(30, 50)]
        assert found(self.ARMS, "head during r_arm mid x1+") == [(35, 38)]
        assert found(self.ARMS, "head with r_arm any -> any?", overlaps="all") == [(20, 40)]


class TestTimes:
    def test_they_compare_exactly(self):
        for rate, frames in ((30, 9), (Fraction(30000, 1001), 9), (120, 36), (7, 3)):
            capture = Capture(1, "", "", "", "", Fraction(rate), 100, Meter(Fraction(90)))
            tracks = {"r_arm": track("r_arm", f"place low 0 0, right mid 5 {5 + frames}", 100)}

            def hit(length, recording=(capture, tracks)):
                return any(True for _ in find(parse(f"r_arm mid {length}"), [recording]))

            exact = Fraction(frames) / rate
            assert hit("<0.3s") == (exact < Fraction(3, 10))
            assert hit("<=0.3s") == (exact <= Fraction(3, 10))
            assert hit("300ms+") == (exact >= Fraction(3, 10))
            assert hit(">0.3s") == (exact > Fraction(3, 10))
            assert hit("0.45b+") == (exact * 90 / 60 >= Fraction(45, 100))
            assert hit("0.3s") == (Fraction(24, 100) <= exact <= Fraction(36, 100))
            assert hit("0.2s..0.3s") == (Fraction(2, 10) <= exact <= Fraction(3, 10))
            assert hit(f"{frames}f..{frames}f")

    def test_tolerance_is_exact_and_inclusive(self):
        arms = "r_arm: place low 0 0, right high 10 20; l_arm: place low 0 0, left high 13 23"
        for tolerance, together in (("0.3", True), ("0.29", False), ("0", False)):
            options = {"tolerance": Fraction(tolerance)}
            for relation in ("starting with", "ending with", "exactly with"):
                spans = found(arms, f"r_arm high {relation} l_arm high", **options)
                assert spans == ([(10, 23)] if together else [])

    def test_edges_that_agree_need_share_no_frame(self):
        arms = "r_arm: place low 0 0, right high 10 11; l_arm: place low 0 0, left high 11 12"
        assert found(arms, "r_arm high starting with l_arm high") == [(10, 12)]
        assert found(arms, "r_arm high with l_arm high") == []


class TestOneMovementServesOneLine:
    ARMS = (
        "r_arm: place low 0 0, right mid 10 20, right high 22 30; "
        "l_arm: place low 0 0, left mid 12 18; head: forward mid 0 0, left mid 5 28"
    )

    def test_beside_each_other(self):
        assert found(self.ARMS, "r_arm mid with r_arm mid") == []
        assert found(self.ARMS, "arm mid with arm mid") == [(10, 20)]
        assert found(self.ARMS, "arm mid with arm mid with arm mid") == []
        assert found(self.ARMS, "r_arm mid -> high with r_arm any -> any") == []
        assert found(self.ARMS, "r_arm mid ... high with r_arm low -> mid") == []

    def test_in_a_repeat_too(self):
        assert found(self.ARMS, "r_arm any with head") == [(5, 28)]
        assert found(self.ARMS, "(r_arm mid/high with head) x2") == []
        assert found(self.ARMS, "(r_arm mid/high with head) x2+") == []
        once = found(self.ARMS, "(r_arm mid/high with head) x1+", overlaps="all")
        assert once == [(5, 28), (5, 30)]

    def test_a_rest_is_another_thing_than_its_movement(self):
        assert found(self.ARMS, "r_arm low ... high with r_arm hold 0.2s") == [(0, 30)]
        assert found(self.ARMS, "r_arm low ... high without r_arm hold 1s+") == []
        assert found(self.ARMS, "r_arm mid -> high without r_arm hold 1s+") == [(10, 30)]
        assert found(self.ARMS, "r_arm at high with r_arm hold") == [(29, 100)]

    def test_what_is_without_must_be_another(self):
        assert found(self.ARMS, "r_arm mid without r_arm") == [(10, 20)]
        assert found(self.ARMS, "r_arm mid ... high without arm") == []
        assert found(self.ARMS, "r_arm mid with l_arm mid without arm") == [(10, 20)]
        assert found(self.ARMS, "arm mid without arm mid") == []


def test_the_latest_start_of_what_ends_earliest():
    left = "l_arm: place low 0 0, left mid 2 11, left mid 12 19"
    arms = f"r_arm: place low 0 0, right high 10 20; {left}"
    assert found(arms, "r_arm high with l_arm mid") == [(10, 20)]


def test_the_latest_start_of_alternatives_that_begin_and_end_alike():
    others = "l_arm: place low 0 0, left mid 2 11; head: forward mid 0 0, left mid 8 12"
    arms = f"r_arm: place low 0 0, right high 10 20; {others}"
    one, other = "r_arm high with l_arm mid", "r_arm high with head left"
    assert found(arms, f"{one} or {other}") == [(8, 20)]
    assert found(arms, f"{other} or {one}") == [(8, 20)]


def test_tracks_may_be_empty_or_missing():
    capture = Capture(1, "", "", "", "", Fraction(30), 0)
    empty = {"r_arm": Track("r_arm", blank(0), ())}
    for tracks in ({}, empty):
        for pattern in ("r_arm", "arms -> hold", "r_arm ... end", "start -> r_arm", "r_arm at any"):
            assert list(find(parse(pattern), [(capture, tracks)])) == []


def test_hits_come_capture_by_capture_as_they_are_found():
    (recording,) = recordings_of("fps 10 frames 100; r_arm: place low 0 0, right mid 5 12")

    def recordings():
        yield recording.capture, recording.tracks
        raise RuntimeError("asked for more")

    hits = find(parse("r_arm mid"), recordings())
    assert next(hits).span == Span(5, 12)
    with pytest.raises(RuntimeError):
        next(hits)


def test_options_must_make_sense():
    with pytest.raises(UsageError, match="none or all"):
        find(parse("r_arm"), [], overlaps="some")
    with pytest.raises(UsageError, match="0 or more"):
        find(parse("r_arm"), [], tolerance=Fraction(-1))
