"""Pipes and columns, through a library."""

from pathlib import Path

import pytest
from query_cases import recordings_of

from lanindex import part
from lanindex.errors import UsageError
from lanindex.pipeline.library import Library, open_library
from lanindex.search.hits import Counts, Hits, hits_in

ARMS = (
    "capture one fps 10 frames 90 Dancer Ann; "
    "r_arm: place low 0 0, right high 10 20, left low 30 40; "
    "capture two fps 20 frames 90 Dancer Bob; "
    "r_arm: place low 0 0, right high 10 18, back high 30 36"
)


@pytest.fixture
def library(tmp_path: Path):
    with open_library(tmp_path / "made.db", create=True) as made:
        for recording in recordings_of(ARMS):
            capture = recording.capture
            made.store.add(
                *(tmp_path / f"{recording.name}.lnd", recording.score()),
                **{"format": "lnd", "sha256": "0" * 64, "label": "", "metadata": capture.metadata},
            )
        yield made


def test_hits_are_sorted_and_cut(library: Library):
    hits = library.search("r_arm high | sort by match.length | first 2")
    assert isinstance(hits, Hits)
    assert [(hit.start, hit.stop) for hit in hits] == [(30, 36), (10, 18)]


def test_hits_are_counted(library: Library):
    counts = library.search("r_arm high | count by clip.dancer")
    assert isinstance(counts, Counts)
    assert counts.dicts() == [
        {"by": "clip.dancer", "value": "Bob", "count": 2},
        {"by": "clip.dancer", "value": "Ann", "count": 1},
    ]
    assert library.search(part("r_arm").to("high").count())[0].count == 3


def test_a_column_that_no_capture_has(library: Library):
    with pytest.raises(UsageError, match=r'"dancers", wanted clip and one of path, .*, dancer'):
        library.search("r_arm high | count by clip.dancers")
    with pytest.raises(UsageError, match='no capture has a column "style"'):
        library.search('r_arm high where clip.style = "jazz"')


def test_a_score_with_its_timing(library: Library):
    score = "#speed=60\n#unit1\ndirection r_arm right high 1 2\ndirection r_arm left low 3 4\n"
    assert len(library.search(score)) == 1
    assert len(library.search(score, strict=True)) == 1
    assert len(library.search(score.replace("3 4", "2 3"), strict=True)) == 0
    assert "about 1 s" in library.explain(score, strict=True).english


def test_hits_in_another_order_are_made_as_well(library: Library):
    hits = hits_in(library.search("a: r_arm any | sort by match.length"))
    assert [hit.capture.path[-7:-4] for hit in hits] == ["two", "two", "one", "one"]
    assert [len(list(again)) for again in (hits, hits.by_fit(), hits[::-1])] == [4, 4, 4]
    assert list(hits[::-1]) == list(hits)[::-1]
    assert len(library.search("a: r_arm any | sort by a.margin")) == 4
