"""The hand-worked cases of the language once more, through the store and the library's search."""

from pathlib import Path

import pytest
from query_cases import Case, cases

from lanindex.pipeline import Library, open_library

CASES = [case for case in cases() if not case.error and "| count" not in case.pattern]


@pytest.fixture(scope="module")
def libraries(tmp_path_factory: pytest.TempPathFactory):
    """Return a function that gives the library with the captures of a case."""
    folder = tmp_path_factory.mktemp("cases")
    opened: dict[int, Library] = {}

    def library_of(case: Case) -> Library:
        key = id(case.recordings)
        if key not in opened:
            library = opened[key] = open_library(folder / f"{len(opened)}.db", create=True)
            for recording in case.recordings:
                capture = recording.capture
                library.add(
                    folder / f"{recording.name or 'only'}.lnd",
                    recording.score(),
                    format="lnd",
                    sha256="0" * 64,
                    label=capture.label,
                    metadata=capture.metadata,
                )
        return opened[key]

    yield library_of
    for library in opened.values():
        library.close()


@pytest.mark.parametrize("case", CASES, ids=str)
def test_through_the_store(case: Case, libraries) -> None:
    library = libraries(case)
    hits = library.search(case.pattern, tolerance=float(case.tolerance), overlaps=case.overlaps)
    found = [
        (
            Path(hit.capture.path).stem,
            hit.span,
            sorted(f"{symbol.part}.{symbol.ordinal}" for symbol in hit.symbols),
        )
        for hit in hits
    ]
    assert found == [(it.name or "only", it.span, sorted(it.symbols)) for it in case.hits]
