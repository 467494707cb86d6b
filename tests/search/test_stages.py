"""Pipes: hits sorted, cut and counted."""

from fractions import Fraction

import pytest

from lanindex.errors import UsageError
from lanindex.model import Capture, Hit, Span, Symbol
from lanindex.search.hits import Counts, Hits, ListedHits, hits_in, piped, value_of
from lanindex.search.language import parse
from lanindex.search.language.clauses import Reference


def symbol(part: str, words: str, start: int, stop: int, margin: float = 1.0) -> Symbol:
    direction, level = words.split()
    return Symbol(
        *(part, 0, None if direction == "-" else direction, None if level == "-" else level),
        *(start, stop, start, stop - start, False, 0, 2, margin, None, None, None),
    )


def hit(label: str, start: int, stop: int, words: str, take: str = "", rate: int = 10) -> Hit:
    arm = symbol("r_arm", words, start, stop, 0.25)
    nod = symbol("head", "forward mid", start + 1, stop + 3)
    capture = Capture(
        *(start + 1, f"{label}.bvh", "bvh", "", label, Fraction(rate), 100),
        metadata={"Take": take, "dancer": ""},
    )
    labels = {"a": (arm,), "b": (arm, nod)} if take else {}
    return Hit(capture, Span(start, stop), 0.25, ((arm,),), labels)


HITS = ListedHits(
    [
        hit("bow", 20, 40, "right high", "10"),
        hit("wave", 50, 55, "left low", "9"),
        hit("bow", 60, 70, "place mid", "x"),
        hit("", 0, 10, "- -"),
    ],
    "made",
)


def found(stages: str) -> Hits | Counts:
    query = parse(f"a: r_arm high with b: head | {stages}")
    return piped(query.stages, HITS)


def starts(stages: str) -> list[int]:
    return [it.span.start for it in hits_in(found(stages))]


def test_sorting_puts_the_smallest_first_and_what_is_missing_last():
    assert starts("sort by match.start") == [0, 20, 50, 60]
    assert starts("sort by match.length") == [50, 60, 0, 20]
    assert starts("sort by a.level") == [50, 60, 20, 0]
    assert starts("sort by a.direction") == [50, 60, 20, 0]
    assert starts("sort by match.level") == [50, 60, 20, 0]
    assert starts("sort by clip.label") == [20, 60, 50, 0]
    assert starts("sort by clip.take") == [50, 20, 60, 0]
    assert starts("sort by b.length") == [50, 60, 20, 0]


def test_ties_stay_as_they_were():
    assert starts("sort by clip.format") == [20, 50, 60, 0]
    assert starts("sort by match.start | sort by clip.format") == [0, 20, 50, 60]
    assert starts("sort by clip.nothing") == [20, 50, 60, 0]


def test_times_of_captures_of_other_rates_are_compared_in_seconds():
    hits = ListedHits(
        [hit("slow", 9, 19, "right mid", rate=10), hit("fast", 30, 60, "right mid", rate=60)], ""
    )
    ordered = piped(parse("r_arm | sort by match.start").stages, hits)
    assert [it.span.start for it in hits_in(ordered)] == [30, 9]


def test_the_first_ones():
    assert starts("first 2") == [20, 50]
    assert starts("sort by match.start | first 1") == [0]
    assert starts("first 2 | sort by match.length") == [50, 20]
    assert starts("first 99") == [20, 50, 60, 0]


def counts(stages: str) -> list[tuple[str | float | None, int]]:
    counted = found(stages)
    assert isinstance(counted, Counts)
    return [(it.value, it.count) for it in counted]


def test_counts_have_the_most_frequent_value_first():
    assert counts("count by clip.label") == [("bow", 2), ("wave", 1), (None, 1)]
    assert counts("count by a.level") == [("low", 1), ("mid", 1), ("high", 1), (None, 1)]
    assert counts("count by clip.take") == [("9", 1), ("10", 1), ("x", 1), (None, 1)]
    assert counts("count by match.length") == [(1, 2), (0.5, 1), (2, 1)]
    assert counts("count by clip.label | first 1") == [("bow", 2)]
    assert counts("first 2 | count by clip.label") == [("bow", 1), ("wave", 1)]


def test_all_hits_together():
    assert counts("count") == [(None, 4)]
    assert counts("first 3 | count") == [(None, 3)]


def test_counts_as_objects():
    counted = found("count by clip.label")
    assert isinstance(counted, Counts)
    assert counted.total == 4
    assert counted.dicts()[0] == {"by": "clip.label", "value": "bow", "count": 2}
    assert repr(counted) == "<4 hits by clip.label: made>\n  bow  2\n  wave  1\n  None  1"
    assert len(counted[:2]) == 2
    assert counted[:2].total == 3
    assert not piped(parse("r_arm | count").stages, ListedHits([], ""))


def test_counts_have_no_clips():
    with pytest.raises(UsageError, match="only counted"):
        hits_in(found("count"))


def test_what_a_field_of_several_symbols_is():
    one = HITS[0]
    several = {name: value_of(Reference("b", name), one) for name in ("start", "end", "part")}
    assert several == {"start": 2, "end": Fraction(43, 10), "part": "head"}
    assert value_of(Reference("a", "margin"), one) == Fraction(1, 4)
    assert value_of(Reference("a", "swings"), one) == 2
    assert value_of(Reference("match", "end"), one) == 4
    assert value_of(Reference("clip", "fps"), one) == 10
    assert value_of(Reference("clip", "seconds"), one) == 10
    assert value_of(Reference("clip", "dancer"), one) is None
    assert value_of(Reference("a", "start"), HITS[3]) is None
