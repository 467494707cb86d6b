from fractions import Fraction

import generated_patterns
import pytest
from effort import examples, thinned
from generated_patterns import random_patterns
from hypothesis import assume, given
from plain_matcher import find
from query_cases import cases, recordings_of

from lanindex.errors import PatternError
from lanindex.search.explain.english import explanation, order, sentence, step_counts
from lanindex.search.explain.why import trace
from lanindex.search.language import parse

ALONE = [case for case in cases() if not case.error and len(case.recordings) == 1]

SENTENCES = {
    "r_arm right mid": "The right arm moves to the right, at middle height.",
    "r_arm place low -> hold 2s+": (
        "The right arm moves straight down (or begins there), "
        "then stays where it is, for at least 2 s."
    ),
    "arms at high <1b": "Both arms together are high, for less than 1 beat.",
    "arms side -> hold": (
        "Both arms together move to their own sides (or begin there), then stay where they are."
    ),
    "r_arm -> high": "The right arm moves anywhere (or begins there), then moves high.",
    "r_arm rising high -> low": (
        "The right arm moves to a higher level than before, high, then moves low."
    ),
    "head not forward ...[<=1] forward/left ... end": (
        "The head moves not forward (or begins there), later (at most 1 movement between) "
        "moves forward or to the left, some time before the clip's end."
    ),
    "(arm rising x2+ without head) 1s..2s either side": (
        "(Either arm moves to a higher level than before, 2 or more times in a row; "
        "and in the meantime never: the head moves anywhere), for 1 s to 2 s. "
        "Or the mirror image of all this."
    ),
    "r_arm via right -> at high": (
        "The right arm goes, if only in passing, to the right, then is high."
    ),
    "arms via any": "Both arms together go, if only in passing, anywhere.",
    "r_arm high with[1s] head without[500ms] l_arm": (
        "The right arm moves high; and not 1 s or more away, the head moves anywhere; "
        "and not even 500 ms away: the left arm moves anywhere."
    ),
    "r_arm high after[<1s] head before l_arm low never leg": (
        "The right arm moves high; and before it begins (less than 1 s between), the head moves "
        "anywhere; and when it is over, the left arm moves low; "
        "and nowhere in the clip: either leg moves anywhere."
    ),
    "a: r_arm high x2 with b: l_arm where a mirrors b and b.start - a.end < 0.5s": (
        "The right arm moves high, 2 times in a row (call it a); and in the meantime, sharing a "
        "frame at least, the left arm moves anywhere (call it b). "
        "And so that a is the mirror image of b and b's start less a's end is less than 0.5 s."
    ),
    'r_arm low -> high rhythm 1:2.5 where clip.label = "wave" and match.swings >= 2': (
        "The right arm moves low (or begins there), then moves high. Its steps last in proportion "
        '1 : 2.5, give or take a quarter. And so that the clip\'s label is "wave" '
        "and the hit's number of swings is at least 2."
    ),
    "let up = mid -> high; r_arm low -> @up": (
        "The right arm moves low (or begins there), then (moves at middle height, then moves high)."
    ),
    "head | sort by match.length | first 3 | count by clip.dataset": (
        "The head moves anywhere. Then sort them by the hit's length, the smallest first. "
        "Then keep the first 3. Then count the hits by the clip's dataset."
    ),
    "start ->[<10f] l_foot back? -> high or r_support": (
        "From the clip's start (after less than 10 frames): the left foot moves back "
        "(or leaves this out), then moves high — or — the right support moves anywhere."
    ),
}


@pytest.mark.parametrize("text", SENTENCES)
def test_a_query_in_english(text):
    assert sentence(parse(text)) == SENTENCES[text]


def test_an_explanation():
    (recording,) = recordings_of(
        "fps 10 frames 90; r_arm: right mid 0 0, place low 5 9, right mid 10 20, place high 30 40"
    )
    query = parse("arm mid -> high <2s with head either side")
    found = explanation(query, [(recording.capture, recording.tracks)])
    assert str(found).splitlines() == [
        "Either arm moves at middle height (or begins there), then moves high, for less than 2 s; "
        "and in the meantime, sharing a frame at least, the head moves anywhere. "
        "Or the mirror image of all this.",
        "",
        "Each step alone:",
        "  arm mid       1",
        "  arm high <2s  1",
        "  head          0",
        "",
        "Order of work:",
        "  1. Take the tracks of head, l_arm, r_arm.",
        "  2. Begin at each arm mid, and follow arm mid -> high <2s",
        "  3. Keep what is with head",
        "  4. Do the same with the mirror image.",
        "  5. From each beginning keep what ends first.",
    ]


@examples(60)
@given(generated_patterns.patterns())
def test_every_query_is_explained(text):
    try:
        query = parse(text)
    except PatternError:
        assume(False)
    said = sentence(query)
    assert said.endswith(".")
    assert said.lstrip("(")[0].isupper()
    assert len(order(query)) >= 3
    assert step_counts(query, [])


@pytest.mark.parametrize("text", list(random_patterns(5, 60)))
def test_the_whole_language_is_explained(text):
    said = sentence(parse(text))
    assert said.endswith(".")
    assert not set(said) & set("{}[]")
    assert len(order(parse(text))) >= 3


@examples(60)
@given(generated_patterns.steps_of("l_arm"), generated_patterns.recordings())
def test_a_step_alone_matches_as_often_as_it_is_found(step, recording):
    query = parse(step)
    hits = list(find(query, [recording], overlaps="all"))
    assert step_counts(query, [recording]) == {str(query): len(hits)}


@pytest.mark.parametrize("case", thinned(ALONE, 4), ids=str)
def test_an_obstacle_is_named_where_nothing_is_found(case):
    query = parse(case.pattern)
    (recording,) = case.recordings
    seen = trace(query, recording.capture, recording.tracks, tolerance=case.tolerance)
    assert (seen.obstacle == "nothing: it is found") == bool(case.hits)


def test_obstacles():
    (recording,) = recordings_of(
        "fps 10 frames 100; r_arm: place low 0 0, right mid 5 12, place high 30 36; "
        "l_arm: place low 0 0, left high 50 60"
    )

    def said(text):
        return trace(parse(text), recording.capture, recording.tracks).obstacle

    assert said("r_arm mid ->[<1s] high") == (
        "after r_arm right mid [5, 12) place high [30, 36) comes after 1.80 s, wanted [<1s]"
    )
    assert said("r_arm high 1s or head") == (
        "r_arm place high [30, 36) takes 0.60 s, wanted 1s; or "
        "this capture does not tell where the head is"
    )
    assert said("r_arm left or r_arm mid") == "nothing: it is found"
    beside = parse("r_arm mid starting with l_arm high")
    seen = trace(beside, recording.capture, recording.tracks, tolerance=Fraction(5))
    assert seen.obstacle == "nothing: it is found"
