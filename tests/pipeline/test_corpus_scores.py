"""Each score of the corpus, pasted as a pattern, finds itself, with and without timing."""

from pathlib import Path

import pytest
from conftest import REPOSITORY

from lanindex.pipeline.library import Library, open_library
from lanindex.search.hits import hits_in
from lanindex.search.language.score import pattern_in

SCORES = sorted((REPOSITORY / "corpus").glob("*.lnd"))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory):
    with open_library(tmp_path_factory.mktemp("scores") / "made.db", create=True) as made:
        made.ingest(SCORES)
        yield made


@pytest.mark.parametrize("strict", [False, True], ids=["free", "strict"])
@pytest.mark.parametrize("score", SCORES, ids=lambda path: path.stem)
def test_it_finds_itself(library: Library, score: Path, strict: bool) -> None:
    hits = hits_in(library.search(pattern_in(f"@{score}"), strict=strict))
    assert [Path(hit.path).name for hit in hits] == [score.name]


def test_another_tempo_is_found_where_timing_is_free(library: Library) -> None:
    slow = (REPOSITORY / "corpus" / "marching.lnd").read_text().replace("#speed=100", "#speed=60")
    assert len(library.search(slow)) == 1
    assert len(library.search(slow, strict=True)) == 0
