"""A library in groups, and what recurs in it."""

from pathlib import Path

import pytest
from dances import BOW, RAISE, dance

from lanindex.errors import UsageError
from lanindex.pipeline import Library, open_library


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
    assert [named(group) for group in library.similar(within="bow*").groups] == [
        {"bow", "bow_again"}
    ]
    assert library.similar(where={"label": "none"}).groups == []


@pytest.mark.parametrize(
    ("how", "message"),
    [({"alike": 0.0}, "--alike: 0.0"), ({"alike": 1.5}, "1.5"), ({"groups": 0}, "--groups: 0")],
)
def test_numbers_that_make_no_sense_are_told(library: Library, how, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        library.similar(**how)


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
    assert library.motifs(within="none").found == []


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
