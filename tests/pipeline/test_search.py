"""Search in a library: which parts a pattern may name."""

import json
from pathlib import Path

import pytest
from dances import BOW
from sample_library import sample_score

from lanindex import pattern_tree
from lanindex.alphabet import TRACKS
from lanindex.errors import LibraryError, PatternError, UsageError
from lanindex.library.selection import Selection
from lanindex.pipeline.library import Library, open_library


@pytest.fixture
def library(tmp_path: Path):
    (tmp_path / "bow.lnd").write_text(BOW)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


@pytest.mark.parametrize("part", ["tail", "r_tail", "tails"])
def test_a_part_that_is_not_there_is_told_with_those_that_are(library: Library, part: str) -> None:
    with pytest.raises(PatternError, match=f'no part "{part}". The parts are: r_arm$'):
        library.search(f"{part} high")


def test_a_part_that_no_capture_has_never_moves_and_that_is_said(library: Library) -> None:
    for pattern, hits, absent in (
        ("head high", 0, "head"),
        ("r_arm forward without head", 1, "head"),
        ("arm forward never turn", 1, "body_turn"),
        ("r_arm forward without hands touch", 1, "hands_touch"),
        ("body turn left with legs high", 0, "r_leg, l_leg, body_turn"),
        ("r_arm forward", 1, ""),
    ):
        library.notes.clear()
        assert len(library.search(pattern)) == hits
        said = f"no capture that was searched has symbols of {absent}"
        assert library.notes == ([said] if absent else [])


def test_where_palms_face_is_rarely_told(library: Library) -> None:
    assert len(library.search("r_palm high")) == 0
    assert "lanindex inspect FILE" in library.notes[-1]


def test_hits_are_of_the_library_that_was_searched(library: Library) -> None:
    score, wanted = library.score("bow.lnd"), library.search("r_arm forward")[0].span
    place = library.capture("bow.lnd").location
    with open_library(library.store.place) as other:
        found = library.search("r_arm forward")
        other.label("bow.lnd", "bow")
        assert found[0].span == wanted
        for change in (
            lambda: other.store.add(place, sample_score(), format="lnd", sha256="0"),
            lambda: other.remove(place),
        ):
            found = library.search("r_arm any")
            change()
            with pytest.raises(
                LibraryError, match=r"gone, or others now. Search again: the library"
            ):
                list(found)
            other.store.add(place, score, format="lnd", sha256="0")


def test_only_captures_that_fit_are_searched(library: Library) -> None:
    pattern = "r_arm forward"
    library.label("bow.lnd", "bow", {"who": "x"})
    wanted = len(library.search(pattern))
    for where, found in (
        ({"label": "b?w", "who": "x"}, wanted),
        ({"label": "wave"}, 0),
        ([("format", "lnd"), ("format", "bvh")], 0),
    ):
        assert len(library.search(pattern, Selection(where=where))) == found
        assert len(library.search(pattern, Selection("*.lnd", where=where))) == found
        assert len(library.search(pattern, Selection("*.bvh", where=where))) == 0
        explained = library.explain(pattern, selection=Selection(where=where))
        assert f"r_arm forward  {found}\n" in str(explained)
        assert explained.record()["steps"] == [{"step": pattern, "count": found}]
    with pytest.raises(UsageError, match="no capture has a column"):
        library.search(pattern, Selection(where={"whom": "x"}))


def test_what_is_known_of_a_pattern_while_it_is_typed(library: Library) -> None:
    found = json.loads(json.dumps(library.parse("r_arm forward -> hi", 19)))
    assert (found["tree"], found["english"]) == (None, None)
    assert (found["error"]["start"], found["error"]["stop"]) == (17, 19)
    (first, *_) = found["completions"]
    assert (first["text"], first["start"], first["stop"]) == ("high", 17, 19)
    whole = library.parse("r_arm forward -> high")
    assert whole["error"] is None
    assert whole["tree"] == pattern_tree("r_arm forward -> high")
    assert whole["english"].startswith("The right arm moves forward")
    word = library.parse("waving")
    assert word["tree"] == pattern_tree("@wave")
    assert library.parse("")["completions"]


def test_each_remedy_is_a_whole_pattern(library: Library) -> None:
    advice = library.suggest("r_arm low -> high")
    record = json.loads(json.dumps(advice.record()))
    assert record["pattern"] == "r_arm low -> high"
    assert record["left_out"]
    for remedy in (*record["left_out"], *record["instead"]):
        assert len(library.search(remedy["pattern"])) == remedy["hits"] > 0


def test_what_would_be_found_is_what_is_found(library: Library) -> None:
    advice = library.suggest("r_arm low -> high | first 2")
    assert advice.instead[0].pattern == "r_arm low -> mid"
    for suggestion in advice.instead:
        found = library.search(suggestion.pattern)
        assert (len(found), found.captures) == (suggestion.hits, suggestion.captures)


def test_brackets_with_a_length_are_tried_as_well(library: Library) -> None:
    advice = library.suggest("(r_arm forward -> low) <0.5s")
    assert str(advice.left_out[0]) == 'without "<0.5s": 1 hit, the nearest takes 2.25 s'


def test_no_verb_refuses_a_part_of_the_alphabet(library: Library) -> None:
    library.store.check_parts(TRACKS)
    with pytest.raises(UsageError, match=r'--part: "tail", wanted one of r_arm .* head torso'):
        library.store.check_parts(["r_arm", "tail"])
