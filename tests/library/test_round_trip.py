"""Stored captures come back, field by field."""

from effort import examples
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import assert_same_score, scores, wild_scores

from lanindex.library import connect
from lanindex.library.store import Store

IN_FILE = connect.in_file  # as it is where libraries are in SQLite


def can_be_kept(*scores):
    """Leave out what PostgreSQL refuses: text with a NUL in it."""
    parts = [part for score in scores for part in score.tracks]
    assume(connect.in_file is IN_FILE or not any("\0" in part for part in parts))


@examples(50)
@given(wild_scores(), wild_scores())
def test_any_score_comes_back(first, second):
    can_be_kept(first, second)
    with Store.open(":memory:", create=True) as library:
        numbers = [
            library.add(name, score, format="bvh", sha256="0")
            for name, score in (("a.bvh", first), ("b.bvh", second))
        ]
        for number, score in zip(numbers, (first, second), strict=True):
            assert_same_score(library.score(number), score)


@examples(50)
@given(scores(), st.data())
def test_tracks_are_those_of_the_score(score, data):
    only = data.draw(st.none() | st.lists(st.sampled_from([*score.tracks, "torso"]), unique=True))
    can_be_kept(score)
    with Store.open(":memory:", create=True) as library:
        number = library.add("a.bvh", score, format="bvh", sha256="0")
        ((capture, tracks),) = library.tracks(parts=only)
    assert capture.id == number
    wanted = [part for part in score.tracks if only is None or part in only]
    assert list(tracks) == wanted
    for part in wanted:
        assert tracks[part].symbols.tolist() == score.tracks[part].symbols.tolist()
        assert tracks[part].known == score.tracks[part].known


@examples(50)
@given(scores(), scores())
def test_a_score_takes_the_place_of_an_earlier_one(first, second):
    can_be_kept(first, second)
    with Store.open(":memory:", create=True) as library:
        number = library.add("a.bvh", first, format="bvh", sha256="0", label="walk")
        assert library.add("a.bvh", second, format="bvh", sha256="1") == number
        assert_same_score(library.score(number), second)
        (capture,) = library.captures()
    assert (capture.sha256, capture.label) == ("1", "walk")
