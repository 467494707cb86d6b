"""Groups of similar captures, and motifs."""

from pathlib import Path

import numpy as np
import pytest
from dances import BOW, RAISE, dance

from lanindex.errors import UsageError
from lanindex.library.selection import Selection
from lanindex.pipeline.example import sampled
from lanindex.pipeline.library import Library, open_library


@pytest.fixture
def library(tmp_path: Path):
    dance(tmp_path / "bow.bvh", BOW)
    dance(tmp_path / "bow_again.bvh", BOW, rate=60)
    for name, rate in (("raise", 30), ("raise_fast", 60), ("raise_slow", 25)):
        dance(tmp_path / f"{name}.bvh", RAISE, rate)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


def named(group) -> set[str]:
    return {Path(capture.path).stem for capture in group.captures}


def test_captures_that_are_alike_are_a_group(library: Library) -> None:
    found = library.similar()
    raises, bows = found.groups
    assert named(raises) == {"raise", "raise_fast", "raise_slow"}
    assert named(bows) == {"bow", "bow_again"}
    assert min(raises.likeness, bows.likeness) > 0.7
    assert (found.captures, found.pairs, found.every) == (5, 10, True)
    assert len(library.similar(groups=1).groups) == 1
    assert len(library.similar(groups=5).groups) == 5
    assert [named(group) for group in library.similar(Selection("bow*")).groups] == [
        {"bow", "bow_again"}
    ]
    assert library.similar(Selection(where={"label": "none"})).groups == []


def test_there_are_as_many_groups_as_are_wanted(library: Library) -> None:
    for wanted in range(1, 6):
        assert len(library.similar(groups=wanted).groups) == wanted
    assert len(library.similar(groups=9).groups) == 5


def test_of_a_large_library_a_sample_is_looked_at(library: Library) -> None:
    found = library.similar(sample=3)
    assert (found.captures, found.of) == (3, 5)
    assert sum(len(group.captures) for group in found.groups) == 3
    assert named(found.groups[0]) <= {"raise", "raise_fast", "raise_slow", "bow", "bow_again"}
    every = library.similar(sample=None)
    assert (every.captures, every.of) == (5, 5)
    motifs = library.motifs(min_count=2, length=2, sample=3)
    assert (motifs.captures, motifs.of) == (3, 5)
    places = {place.capture.path for motif in motifs.found for place in motif.places}
    assert len(places) <= 3
    assert library.motifs(sample=None).captures == 5
    for verb in (library.similar, library.motifs):
        with pytest.raises(UsageError, match="a sample of 0, wanted 1 or more"):
            verb(sample=0)


def test_a_sample_is_the_same_each_time_and_in_order() -> None:
    numbers = np.arange(1000)
    places = sampled(numbers, 50)
    assert places.tolist() == sorted(set(places.tolist())) == sampled(numbers, 50).tolist()
    assert len(places) == 50
    assert (
        sampled(numbers[:7], 50).tolist() == sampled(numbers[:7], None).tolist() == list(range(7))
    )


@pytest.mark.parametrize(
    ("how", "message"),
    [({"alike": 0.0}, "--alike: 0.0"), ({"alike": 1.5}, "1.5"), ({"groups": 0}, "--groups: 0")],
)
def test_numbers_that_make_no_sense_are_told(library: Library, how, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        library.similar(**how)


@pytest.mark.slow
def test_a_motif_is_a_pattern_that_finds_just_what_was_counted(library: Library) -> None:
    found = library.motifs(min_count=2, length=2).found
    assert found
    for motif in found:
        hits = library.search(motif.pattern)
        places = [(place.capture, place.span) for place in motif.places]
        assert [(hit.capture, hit.span) for hit in hits] == places
        assert motif.hits == len(hits)
        assert motif.captures == len({hit.capture.id for hit in hits})
        assert motif.steps == 1 + motif.pattern.count("->")
    assert {motif.part for motif in library.motifs(parts=["l_arm"], length=2).found} <= {"l_arm"}
    assert library.motifs(Selection("none")).found == []


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"parts": ["tail"]}, '"tail", wanted one of '),
        ({"min_count": 1}, "--min-count: 1, wanted 2 or more"),
        ({"length": 1}, "--length: 1, wanted 2 to 12"),
        ({"length": 13}, "--length: 13"),
    ],
)
def test_what_no_motif_can_be_is_told(library: Library, how, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        library.motifs(**how)


def test_motifs_of_real_captures_are_what_a_search_finds(captures: Path, tmp_path: Path) -> None:
    files = sorted((captures / "bvh" / "bandai2").glob("w*/*_normal_*.bvh"))
    assert files
    with open_library(tmp_path / "real.db", create=True) as library:
        library.ingest(files[:8])
        motifs = library.motifs(min_count=4).found
        assert motifs
        for motif in motifs[:25]:
            hits = library.search(motif.pattern)
            places = [(place.capture.id, place.span) for place in motif.places]
            assert [(hit.capture.id, hit.span) for hit in hits] == places
