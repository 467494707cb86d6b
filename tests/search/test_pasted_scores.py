"""Pasted LND as a pattern: a line of it, a block, a whole score."""

import pytest

from lanindex.search.language import parse

SCORE = """// a bow
#speed=120
#rhythm 3/4
#unit_per_line 4
#unit_total 2
#unit0
direction r_arm place low 0 0
direction head forward mid 0 0
direction l_arm place low 0 0
#unit1
direction r_arm right high 1.5 3   // goes on over the bar line
direction l_arm left mid 0 1
#unit2
direction r_arm right high 0 1
direction r_arm place low 1 2
direction l_arm place mid 1 3
"""


def test_a_line_is_a_step():
    assert str(parse("direction r_arm right high 1.5 2.5")) == "r_arm right high"
    assert str(parse("r_arm low -> direction r_arm right mid 0 1 -> high")) == (
        "r_arm low -> r_arm right mid -> high"
    )
    assert str(parse("a: direction head left mid 0 1 <2s x2")) == "a: head left mid <2s x2"
    assert str(parse("mirror(direction r_arm right high 1 2)")) == "l_arm left high"


def test_a_score_is_lines_side_by_side():
    assert str(parse(SCORE)) == (
        "r_arm place low -> right high -> place low "
        "with l_arm place low -> left mid -> place mid "
        "with head at forward mid"
    )


def test_a_score_may_stand_in_a_pattern():
    two = "direction r_arm right high 0 1 direction r_arm place low 1 2"
    assert str(parse(f"r_arm low -> {two} -> high")) == (
        "r_arm low -> (r_arm right high -> place low) -> high"
    )
    assert str(parse(f"{two} with head | first 1")) == (
        "(r_arm right high -> place low) with head | first 1"
    )


def test_lines_without_units_follow_each_other_as_written():
    text = "direction r_arm right high 3 4\ndirection r_arm place low 0 1"
    assert str(parse(text)) == "r_arm right high -> place low"
    with pytest.raises(Exception, match="goes back in time: lines like #unit1"):
        parse(text, strict=True)


def test_strict_timing_is_in_seconds_where_the_score_tells_its_speed():
    assert str(parse(SCORE, strict=True)) == (
        "r_arm place low -> right high 1.25s ->[<=0.25s] place low 0.5s "
        "with l_arm place low -> left mid 0.5s ->[1.5s] place mid 1s "
        "with head at forward mid"
    )


def test_strict_timing_is_in_beats_where_it_does_not():
    text = "direction r_arm right high 0 1\ndirection r_arm place low 1.5 2"
    assert str(parse(text, strict=True)) == "r_arm right high 1b ->[0.5b] place low 0.5b"
    assert str(parse("direction r_arm right high 1.5 2.5", strict=True)) == "r_arm right high 1b"
    assert str(parse("direction r_arm right high 0 1 <2s", strict=True)) == "r_arm right high <2s"


def test_only_pasted_lines_have_strict_timing():
    with pytest.raises(Exception, match="Only the timing of pasted LND can be strict"):
        parse("r_arm right high", strict=True)


def test_a_score_that_loses_sight_of_a_part_is_no_pattern():
    with pytest.raises(Exception, match="not seen before that"):
        parse(f"{SCORE}#unit4\ndirection r_arm right mid 0 0")


def test_what_is_printed_reads_the_same():
    for strict in (False, True):
        query = parse(SCORE, strict=strict)
        assert parse(str(query)) == query
