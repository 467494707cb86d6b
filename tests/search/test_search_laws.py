"""Laws of the language, on random patterns and tracks."""

from fractions import Fraction
from random import Random

import generated_patterns
import numpy as np
import pytest
from effort import examples
from generated_patterns import random_pattern
from hypothesis import assume, given
from hypothesis import strategies as st
from plain_matcher import find
from plain_search import find_plainly

from lanindex.alphabet import MIRRORED, mirrored_part
from lanindex.errors import PatternError
from lanindex.model import Track
from lanindex.search.language import Query, parse
from lanindex.search.language.query import Bracket, mirrored
from lanindex.search.plan import counts

LINES = generated_patterns.lines(depth=1)
PATTERNS = generated_patterns.patterns(depth=1, most=2)
RECORDINGS = generated_patterns.recordings()
quick = examples(50)


def understood(text: str) -> Query:
    try:
        return parse(text)
    except PatternError:
        assume(False)
        raise


def hits(text: str, recording, **options):
    options = {"overlaps": "all", **options}
    return list(find(understood(text), [recording], **options))


def spans(text: str, recording, **options):
    return [(hit.span.start, hit.span.stop) for hit in hits(text, recording, **options)]


def firsts(text: str, recording) -> list[int]:
    return sorted(hit.lines[0][0].ordinal for hit in hits(text, recording))


def in_the_mirror(recording):
    capture, tracks = recording
    turned = {}
    for part, track in tracks.items():
        symbols = track.symbols.copy()
        symbols["direction"] = np.array(MIRRORED)[symbols["direction"]]
        turned[mirrored_part(part)] = Track(mirrored_part(part), symbols, track.known)
    return capture, turned


def agrees(text: str, recording, **options) -> None:
    """Check frames and fit against the twin; only as many ways as can be tried in a moment."""
    query = understood(text)
    found = [(hit.start, hit.stop, hit.fit) for hit in find(query, [recording], **options)]
    assert found == find_plainly(query, *recording, **options)


@examples(100)
@given(LINES, RECORDINGS)
def test_a_line_is_found_as_by_trying_everything(text, recording):
    agrees(text, recording, overlaps="all")


@examples(100)
@given(PATTERNS, RECORDINGS)
def test_lines_side_by_side_are_found_as_by_trying_everything(text, recording):
    agrees(text, recording, overlaps="all", tolerance=Fraction(1, 5))


@examples(300)
@given(st.integers(0, 2**32), RECORDINGS)
def test_the_whole_language_is_found_as_by_trying_everything(seed, recording):
    text = random_pattern(Random(seed), steps=4, avoid={"stages"})
    agrees(text, recording, overlaps="none")


@quick
@given(generated_patterns.patterns())
def test_a_query_prints_as_itself(text):
    query = understood(text)
    assert parse(str(query)) == query
    assert str(parse(str(query))) == str(query)
    assert hash(parse(str(query))) == hash(query)


@quick
@given(generated_patterns.patterns())
def test_twice_mirrored_is_as_before(text):
    query = understood(text)
    assert mirrored(mirrored(query.pattern)) == query.pattern
    (outer,) = parse(f"mirror(mirror({text}))").pattern.alternatives
    bracket = outer.first.items[0].unit
    assert isinstance(bracket, Bracket)
    assert bracket == Bracket(parse(f"({text})").pattern)


@quick
@given(PATTERNS, RECORDINGS)
def test_the_mirror_image_is_found_in_the_mirror(text, recording):
    assert spans(f"mirror({text})", in_the_mirror(recording)) == spans(f"({text})", recording)


@quick
@given(PATTERNS, RECORDINGS)
def test_either_side_is_the_pattern_or_its_mirror_image(text, recording):
    assert spans(f"{text} either side", recording) == spans(
        f"({text}) or mirror({text})", recording
    )


@quick
@given(PATTERNS, RECORDINGS)
def test_brackets_around_all_and_the_same_again_change_nothing(text, recording):
    assert spans(f"({text})", recording) == spans(text, recording)
    assert spans(f"{text} or {text}", recording) == spans(text, recording)


@quick
@given(LINES, RECORDINGS)
def test_a_repeat_is_written_out(text, recording):
    assume("start" not in text)
    assume("end" not in text)
    assert spans(f"({text}) x2", recording) == spans(f"({text}) -> ({text})", recording)
    assert spans(f"({text}) x1", recording) == spans(f"({text})", recording)


@quick
@given(PATTERNS, RECORDINGS)
def test_hits_that_may_not_overlap_are_kept_from_left_to_right(text, recording):
    end, kept = 0, []
    found = spans(text, recording)
    for start, stop in found:
        nearest = max(begin for begin, same in found if same == stop)
        if start >= end and (start == nearest or counts(understood(text).pattern)):
            kept.append((start, stop))
            end = stop
    assert spans(text, recording, overlaps="none") == kept


@quick
@given(generated_patterns.steps_of("r_arm"), generated_patterns.lines(depth=1), RECORDINGS)
def test_with_and_without_share_out_the_movements(step, line, recording):
    beside = firsts(f"{step} with ({line})", recording)
    alone = firsts(f"{step} without ({line})", recording)
    assert sorted(beside + alone) == firsts(step, recording)


@quick
@given(LINES, LINES, RECORDINGS)
def test_with_goes_both_ways(one, other, recording):
    assert bool(hits(f"{one} with {other}", recording)) == bool(
        hits(f"{other} with {one}", recording)
    )


@quick
@given(PATTERNS, RECORDINGS)
def test_a_hit_tells_what_matched(text, recording):
    capture, tracks = recording
    query = understood(text)
    for hit in find(query, [recording], overlaps="all"):
        assert hit.capture is capture
        assert 0 <= hit.span.start < hit.span.stop <= capture.frames
        assert hit.fit == round(min(symbol.margin for symbol in hit.symbols), 3)
        assert {symbol.part for symbol in hit.symbols} <= query.parts
        for line in hit.lines:
            assert line
            for symbol in line:
                assert tracks[symbol.part].listed()[symbol.ordinal] == symbol


@quick
@given(PATTERNS, RECORDINGS)
def test_other_parts_do_not_matter(text, recording):
    capture, tracks = recording
    needed = {part: track for part, track in tracks.items() if part in understood(text).parts}
    assert spans(text, (capture, needed)) == spans(text, recording)


@pytest.mark.slow
@examples(1_000)
@given(st.one_of(LINES, PATTERNS), RECORDINGS)
def test_many_patterns_are_found_as_by_trying_everything(text, recording):
    agrees(text, recording, overlaps="all")
