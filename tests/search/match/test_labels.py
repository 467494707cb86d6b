"""Hits of the engine and of the plain matcher give labels the same events."""

import pytest
from fast_search import find_fast
from plain_matcher import find
from query_cases import recordings_of

from lanindex.search.language import parse

ARMS = (
    "fps 10 frames 100; r_arm: place low 0 0, right mid 10 20, right high 20 30, place high 30 36, "
    "place low 60 70; l_arm: place low 0 0, left mid 12 20, left high 22 30, place low 58 72"
)


@pytest.mark.parametrize(
    "pattern",
    [
        "a: r_arm high",
        "r_arm mid -> a: high -> b: high",
        "a: r_arm high x2",
        "a: (r_arm mid -> b: high)",
        "a: r_arm at high",
        "r_arm high ... a: hold 1s+",
        "a: arms mid -> b: high",
        "a: arms at high",
        "r_arm mid -> a: right? -> b: place",
    ],
)
def test_labels(pattern: str):
    recordings = [(it.capture, it.tracks) for it in recordings_of(ARMS)]
    query = parse(pattern)
    expected = [dict(hit.labels) for hit in find(query, recordings)]
    assert [dict(hit.labels) for hit in find_fast(query, recordings)] == expected
    assert any(expected)
