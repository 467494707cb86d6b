"""A stretch of a capture as a pattern."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import lanindex
from lanindex.errors import UsageError


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[lanindex.Library]:
    path = tmp_path_factory.mktemp("stretch") / "l.db"
    corpus = Path(__file__).parents[2] / "corpus"
    opened = lanindex.open_library(path, create=True)
    opened.ingest(*sorted(corpus.glob("*.bvh")))
    yield opened
    opened.close()


@pytest.mark.parametrize("parts", [None, ["r_arm"], ["l_leg", "torso"]])
def test_the_pattern_of_a_stretch_finds_it(library: lanindex.Library, parts: list[str]) -> None:
    tried = 0
    for capture in library.captures():
        whole = float(capture.frames / capture.rate)
        for start in (0.0, whole / 3):
            stop = min(start + 3, whole)
            try:
                pattern = library.pattern_of(capture.id, start, stop, parts)
            except UsageError:  # nothing moves
                continue
            tried += 1
            own = lanindex.Selection(capture.path)
            spans = [
                (hit.start / capture.rate, hit.stop / capture.rate)
                for hit in library.search(pattern, own, overlaps="all")
            ]
            assert any(begin < stop and start < end for begin, end in spans), (capture, pattern)
    assert tried > 2


def test_a_part_that_has_no_direction_is_no_step(library: lanindex.Library) -> None:
    with pytest.raises(UsageError, match="nothing moves"):
        library.pattern_of("greetings.bvh", 0, 5, ["jump"])
