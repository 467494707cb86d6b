"""Why a pattern finds nothing, and which patterns are offered instead."""

from collections import Counter
from fractions import Fraction
from math import inf

import generated_patterns
import pytest
from effort import examples
from hypothesis import assume, given
from hypothesis import strategies as st
from plain_matcher import find
from query_cases import recordings_of

from lanindex.errors import PatternError
from lanindex.search.explain.advice import (
    Advice,
    Budget,
    LeftOut,
    Suggestion,
    advise,
    changes,
    nearest_limit,
    nodes_of,
)
from lanindex.search.language import parse
from lanindex.search.language.query import Repeat, changed_nodes
from lanindex.search.language.times import Clock, Length, Time


def read(text):
    try:
        return parse(text)
    except PatternError:
        return None


def counting(text, **options):
    recordings = [(it.capture, it.tracks) for it in recordings_of(text)]

    def count(query):
        hits = Counter(hit.capture.id for hit in find(query, recordings, **options))
        return hits.total(), len(hits)

    return count


RAISES = (
    "fps 10 frames 100; r_arm: place low 0 0, right mid 5 12, place high 30 36; "
    "l_arm: place low 0 0, left mid 5 12, place high 30 37; head: place high 0 0, forward high 2 5"
)


OVERLAP = (
    "fps 10 frames 90; r_arm: place low 0 0, right mid 5 12; "
    "head: place high 0 0, forward high 11 30"
)


def advice(pattern, recording=RAISES, seconds=inf):
    return advise(parse(pattern), counting(recording), read, budget=Budget(seconds))


def patterns(found):
    return [it.pattern for it in found.instead]


@examples(40)
@given(generated_patterns.patterns())
def test_every_place_can_be_changed(text):
    query = read(text)
    assume(query)
    for node, put in nodes_of(query):
        assert put(node) == query
    assert changed_nodes(query, lambda it: it) == query
    for other in [it.query for it in changes(query)]:
        assert other != query
        assert str(other) != text


def left_out(text):
    """Return what a query is without each of its conditions, as written."""
    return [(it.condition, str(it.query)) for it in changes(parse(text)) if it.condition]


CHANGES = {
    "r_arm low -> mid": {"r_arm low ... mid", "r_arm mid -> mid", "l_arm low -> mid"},
    "arms right high": {"arms side high", "arm right high", "hands right high"},
    "r_arm at side_forward": {"r_arm side_forward", "r_arm at side", "l_arm at side_forward"},
    "(arm low -> high) <1s": {"(arm low ... high) <1s", "(forearm low -> high) <1s"},
    "start -> feet high -> end": {"start ... feet high -> end", "start -> foot high -> end"},
    "r_arm high exactly with head": {"r_arm high with head", "l_arm high exactly with head"},
    "r_arm high overlapping head": {"r_arm high with head", "l_arm high overlapping head"},
    "l_support right": {"l_leg right", "r_support left", "l_support r_forward"},
    "r_arm low -> low -> low": {"r_arm low ... low ... low"},
    "r_arm hold high": {"r_arm at high"},
}


@pytest.mark.parametrize("text", CHANGES)
def test_what_is_near(text):
    changed = {str(it.query) for it in changes(parse(text))}
    assert CHANGES[text] <= changed


def test_every_change_that_is_offered_parses_to_what_was_counted():
    counted = []

    def count(query):
        counted.append(query)
        return 1, 1

    query = parse("r_arm low -> mirror(l_arm right -> mirror(r_arm low -> low x2)) -> low")
    offered = advise(query, count, read, budget=Budget(inf))
    assert all(read(str(it)) == it for it in counted)
    assert {it.pattern for it in offered.instead} <= set(map(str, counted))


def test_a_carried_part_changes_along():
    changed = {str(it.query): it.query for it in changes(parse("r_arm low -> mid"))}
    assert changed["r_forearm low -> mid"] == parse("r_forearm low -> mid")


LEFT_OUT = {
    "r_arm right not low <0.3s": ["<0.3s", "right", "not low"],
    "r_arm low -> high": ["r_arm low ->", "-> high", "low", "high"],
    "r_arm ...[<2s] high x3+": ["r_arm ...[<2s]", "...[<2s] high x3+", "[<2s]", "x3+", "high"],
    "start -> head ...[2] any ... end": [
        *("start ->", "...[2] any", "... end", "[2]"),
    ],
    "r_arm high with l_arm low without head left": [
        *("with l_arm low", "without head left", "high", "low"),
    ],
    "(r_arm high or l_arm) 1s": ["1s", "high"],
}


@pytest.mark.parametrize("text", LEFT_OUT)
def test_each_condition_is_left_out(text):
    assert sorted(condition for condition, _ in left_out(text)) == sorted(LEFT_OUT[text])


def test_a_word_that_stands_twice_is_told_with_its_step():
    waves = "fps 10 frames 90; r_arm: left high 0 0, right high 5 9, left mid 9 12, left low 20 30"
    said = [str(it) for it in advice("r_arm left high -> right mid -> left mid", waves).left_out]
    assert 'without "mid" of "right mid": 1 hit' in said


def test_what_is_left_without_a_condition():
    assert dict(left_out("start -> r_arm low -> at high 2s")) == {
        "start ->": "r_arm low -> at high 2s",
        "-> at high 2s": "start -> r_arm low",
        "2s": "start -> r_arm low -> at high",
        "low": "start -> r_arm -> at high 2s",
    }
    assert ("high", "r_arm low -> any") in left_out("r_arm low -> high")


def test_arms_low_to_high_leads_to_what_is_later():
    found = advice("arms low -> high")
    assert patterns(found)[0] == "arms low ... high"
    assert found.instead[0].hits == 1
    assert str(found).splitlines()[0].startswith('without "')
    assert found.brief == "nearest: arms low ... high (1 hit in 1 capture)"


def test_a_line_that_shares_too_little_leads_to_with():
    found = advice("r_arm right overlapping head high", OVERLAP)
    assert patterns(found)[0] == "r_arm right with head high"


def test_the_nearest_length_is_measured_and_offered():
    found = advice("r_arm high <0.3s")
    assert str(found.left_out[0]) == 'without "<0.3s": 1 hit, the nearest takes 0.6 s'
    assert patterns(found)[0] == "r_arm high <=0.6s"
    assert advice("r_arm right 1s+").left_out[0].nearest == "the nearest takes 0.7 s"
    found = advice("r_arm mid ->[<5f] high")
    near = {it.condition: it.nearest for it in found.left_out}
    assert near["[<5f]"] == "the nearest comes after 18 frames"
    assert "r_arm mid ->[<=18f] high" in patterns(found)


def test_the_nearest_count_is_measured():
    wave = "fps 10 frames 100; r_arm: place low 0 0, right mid 5 9, left mid 9 14, right mid 14 20"
    near = {it.condition: it.nearest for it in advice("r_arm mid x5+", wave).left_out}
    assert near == {"x5+": "3 in a row are the most"}
    near = {it.condition: it.nearest for it in advice("r_arm low ...[0] left", wave).left_out}
    assert near["[0]"] == "the nearest skips 1"


def test_what_is_nowhere_is_said():
    found = advice("r_arm back with head")
    assert found.never == ("r_arm back",)
    assert str(found).startswith('"r_arm back" is nowhere to be found')
    assert advice("r_arm place low -> place high").never == ()


def test_two_changes_where_one_is_not_enough():
    found = advice("arms low -> high <0.3s")
    assert patterns(found)[0] == "arms low ... high"
    found = advice("legs low -> mid")
    assert (found.instead, found.left_out) == ((), ())
    assert "Nor does anything near it find something." in str(found)


def test_a_pattern_that_two_changes_lead_to_is_offered_once():
    assert patterns(advice("r_arm mid -> mid")).count("r_arm mid") == 1


def test_what_there_was_no_time_for_is_counted():
    found = advice("arms low -> high", seconds=0)
    assert found.instead == ()
    assert found.untried > 10
    assert str(found).endswith("changes could not be tried in time.")
    one = Advice("r_arm", left_out=(LeftOut("", 3, 2),), untried=1, remark="So.")
    assert str(one) == "So.\nin all captures: 3 hits\n1 change could not be tried in time."


def test_a_count_that_ran_out_of_time_is_not_taken_for_nothing():
    found = advise(parse("r_arm left"), lambda query: None, read, budget=Budget(inf))
    assert (found.never, found.left_out, found.instead) == ((), (), ())
    assert found.untried > 5


def test_the_nearest_changes_come_first_however_little_they_find():
    found = advice("r_arm low -> high")
    assert patterns(found)[0] == "r_arm low ... high"
    assert isinstance(found.instead[0], Suggestion)
    assert len(found.instead) <= 5


@examples(80)
@given(
    st.lists(st.integers(0, 300), min_size=1, max_size=4),
    st.sampled_from(["<", "<=", ">", ">=", "+", "~", ".."]),
    st.integers(1, 300),
    st.integers(0, 60),
)
def test_the_nearest_length_is_the_nearest(frames, form, number, more):
    """Against a list of lengths, in frames of a hundredth of a second."""
    clock = Clock(Fraction(100), Fraction(1))
    last = Time(Fraction(number + more, 100), "s") if form == ".." else None
    limit = Length(form, Time(Fraction(number, 100), "s"), last)

    def met(other):
        least, most = other.bounds(clock)
        return any(least <= it and (most is None or it <= most) for it in frames)

    assume(not met(limit))
    least, most = limit.bounds(clock)
    away = min(it - most if most is not None and it > most else least - it for it in frames)
    other, told = nearest_limit(limit, met)
    assert met(other)
    seconds = Fraction(told.removesuffix(" s")) * 100
    assert min(abs(least - seconds), abs(seconds - (least if most is None else most))) == away


def test_a_limit_that_nothing_can_meet_has_a_nearest():
    def met(limit):
        least, most = limit.bounds(Clock(Fraction(1), Fraction(1)))
        return least <= 3 and (most is None or most >= 3)

    found = nearest_limit(Length("<", Time(Fraction(0), "f")), met)
    assert found == (Length("<=", Time(Fraction(3), "f")), "3 frames")


def test_a_limit_that_nothing_meets_has_no_nearest():
    assert nearest_limit(Length("<", Time(Fraction(1), "s")), lambda _: False) is None
    assert nearest_limit(Repeat(3, None), lambda _: False) is None
    assert nearest_limit(Length("", Time(Fraction(2), "")), lambda _: False) is None
    four = Length("", Time(Fraction(4), ""))
    assert nearest_limit(Length("", Time(Fraction(2), "")), lambda it: it == four) == (four, "4")
    mixed = Length("..", Time(Fraction(1), "s"), Time(Fraction(2), "b"))
    assert nearest_limit(mixed, lambda _: True) is None
