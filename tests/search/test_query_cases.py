import pytest
from plain_matcher import find
from query_cases import Case, cases, told

from lanindex.errors import PatternError
from lanindex.search.hits import ListedHits, piped
from lanindex.search.language import parse

CASES = list(cases())
ERRORS = [case for case in CASES if case.error]
FOUND = [case for case in CASES if not case.error]


def test_all_cases_are_there():
    assert (len(FOUND), len(ERRORS)) == (609, 86)


@pytest.mark.parametrize("case", FOUND, ids=str)
def test_hits(case: Case):
    query = parse(case.pattern)
    recordings = [(it.capture, it.tracks) for it in case.recordings]
    names = {it.capture.id: it.name for it in case.recordings}
    hits = find(query, recordings, tolerance=case.tolerance, overlaps=case.overlaps)
    found = piped(query.stages, ListedHits(hits, case.pattern))
    assert told(found, names) == list(case.hits)


@pytest.mark.parametrize("case", ERRORS, ids=str)
def test_errors(case: Case):
    with pytest.raises(PatternError) as caught:
        parse(case.pattern)
    assert case.error in str(caught.value)


@pytest.mark.parametrize("case", [case for case in CASES if not case.error], ids=str)
def test_what_is_read_is_printed(case: Case):
    query = parse(case.pattern)
    assert parse(str(query)) == query
