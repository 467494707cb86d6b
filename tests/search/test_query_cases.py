import pytest
from query_cases import NOT_YET_SO, Case, cases

from lanindex.errors import PatternError
from lanindex.search.language import parse
from lanindex.search.plain import find

CASES = list(cases())
NOT_YET = [case for case in CASES if case.not_yet]
ERRORS = [case for case in CASES if case.error]
FOUND = [case for case in CASES if not case.error and not case.not_yet]


def test_all_cases_are_there():
    assert len(CASES) == 173
    assert (len(FOUND), len(ERRORS), len(NOT_YET)) == (143, 18, 16)
    assert {case.line for case in FOUND if case.today != case.hits} == set(NOT_YET_SO)


@pytest.mark.parametrize("case", FOUND, ids=str)
def test_hits(case: Case):
    query = parse(case.pattern)
    recordings = [(it.capture, it.tracks) for it in case.recordings]
    names = {it.capture.id: it.name for it in case.recordings}
    found = []
    for hit in find(query, recordings, tolerance=case.tolerance, overlaps=case.overlaps):
        symbols = sorted(f"{symbol.part}.{symbol.ordinal}" for symbol in hit.symbols)
        found.append((names[hit.capture.id], hit.span, symbols))
    assert found == [(it.name, it.span, sorted(it.symbols)) for it in case.today]


@pytest.mark.parametrize("case", ERRORS, ids=str)
def test_errors(case: Case):
    with pytest.raises(PatternError) as caught:
        parse(case.pattern)
    assert case.error in str(caught.value)


@pytest.mark.parametrize("case", [case for case in CASES if not case.error], ids=str)
def test_what_is_read_is_printed(case: Case):
    query = parse(case.pattern)
    assert parse(str(query)) == query
