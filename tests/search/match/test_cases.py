"""The hand-worked cases of the language through the engine."""

import pytest
from fast_search import find_fast
from plain_matcher import find
from query_cases import Case, cases

from lanindex.search.language import parse

CASES = [case for case in cases() if not case.error and "|" not in case.pattern]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_hits(case: Case) -> None:
    recordings = [(it.capture, it.tracks) for it in case.recordings]
    names = {it.capture.id: it.name for it in case.recordings}
    hits = find_fast(
        parse(case.pattern), recordings, tolerance=case.tolerance, overlaps=case.overlaps
    )
    found = [
        (
            names[hit.capture.id],
            hit.span,
            sorted(f"{symbol.part}.{symbol.ordinal}" for symbol in hit.symbols),
        )
        for hit in hits
    ]
    assert found == [(it.name, it.span, sorted(it.symbols)) for it in case.hits]


def test_labels_come_along() -> None:
    case = next(case for case in CASES if case.pattern == "r_arm right mid -> high")
    recordings = [(it.capture, it.tracks) for it in case.recordings]
    query = parse("a: r_arm right -> b: high -> hold")
    (hit,) = find_fast(query, recordings)
    (expected,) = find(query, recordings)
    assert hit.labels == expected.labels
    assert set(hit.labels) == {"a", "b"}
