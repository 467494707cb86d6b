"""The hand-worked cases of the language once more, through the store and the library's search."""

from pathlib import Path

import pytest
from effort import thinned
from query_cases import Case, cases, told

from lanindex.errors import UsageError
from lanindex.pipeline.library import Library, open_library

CASES = [case for case in cases() if not case.error]


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
                library.store.add(
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


@pytest.mark.parametrize("case", thinned(CASES, 3), ids=str)
def test_through_the_store(case: Case, libraries) -> None:
    library = libraries(case)
    if "clip.nothing" in case.pattern:  # alone it is false, in a library it is a mistake
        with pytest.raises(UsageError, match='no capture has a column "nothing"'):
            library.search(case.pattern)
        return
    found = library.search(case.pattern, tolerance=float(case.tolerance), overlaps=case.overlaps)
    names = {it.id: Path(it.path).stem.removesuffix("only") for it in library.captures()}
    assert told(found, names) == list(case.hits)
