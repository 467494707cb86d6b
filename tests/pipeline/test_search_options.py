"""Search options (near, fuzzy, deadline) reach every kind of search."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from query_cases import recordings_of

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.errors import LanindexError, UsageError
from lanindex.evaluate import Clip, Expectation, evaluate
from lanindex.model import Meter, Score, Track
from lanindex.pipeline.library import Library, open_library
from lanindex.search.language import parse

TRACKS = "fps 10 frames 60; r_arm: place low 0 0, right mid 5 12, place high 20 30"
BORDERING = "r_arm r_forward mid"
"""What the second symbol nearly is."""


@pytest.fixture
def library(tmp_path: Path):
    (recording,) = recordings_of(TRACKS)
    rows = recording.tracks["r_arm"].symbols.copy()
    rows["margin"][1] = 0.1
    rows["runner_direction"][1] = DIRECTION_CODES["r_forward"]
    rows["runner_level"][1] = LEVEL_CODES["mid"]
    track = Track("r_arm", rows, recording.tracks["r_arm"].known)
    score = Score(recording.capture.rate, recording.capture.frames, Meter(), {"r_arm": track})
    with open_library(tmp_path / "lanindex.db", create=True) as opened:
        opened.store.add("one.lnd", score, format="lnd", sha256="0" * 64, label="wave")
        yield opened


@pytest.mark.parametrize("how", [{"near": True}, {"fuzzy": "1"}])
def test_what_is_offered_is_counted_as_it_would_be_found(library: Library, how) -> None:
    pattern = f"{BORDERING} -> high <0.1s"
    assert len(library.search(pattern, **how)) == 0
    bounded = {it.condition: it.hits for it in library.suggest(pattern, **how).left_out}
    assert bounded["<0.1s"] == 1
    assert "<0.1s" not in {it.condition for it in library.suggest(pattern).left_out}
    for offered in library.suggest(pattern, **how).instead:
        assert len(library.search(offered.pattern, **how)) == offered.hits


def test_what_is_near_costs_no_edit(library: Library) -> None:
    assert len(library.search(f"{BORDERING} -> high", fuzzy=0)) == 0
    (hit,) = library.search(f"{BORDERING} -> high", near=True, fuzzy=0)
    assert ([it.start for it in hit.symbols], round(hit.fit, 3)) == (
        [5, 20],
        0.56,
    )  # 1/2, and half of 0.15 of 1.25


def test_a_capture_under_the_glass_is_looked_at_in_the_same_way(library: Library) -> None:
    assert library.why(BORDERING, 1).hits == ()
    ((hit, _),) = library.why(BORDERING, 1, near=True).hits
    assert (hit.start, hit.stop) == (5, 12)


@pytest.mark.parametrize("option", ["--near", "--fuzzy=0.5"])
def test_clips_are_cut_of_it(library: Library, tmp_path: Path, option: str) -> None:
    command = [sys.executable, "-m", "lanindex", "export", BORDERING, "--json"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True).returncode == 1
    done = subprocess.run([*command, option], cwd=tmp_path, capture_output=True, text=True)
    assert json.loads(done.stdout)["clip"] == "one_5-12.lnd"
    assert "one_5-12.lnd" in os.listdir(tmp_path / "clips")


@pytest.mark.parametrize(
    ("how", "found"), [({}, False), ({"near": True}, True), ({"fuzzy": 1}, True)]
)
def test_clips_are_judged_by_it(library: Library, how, found: bool) -> None:
    ((capture, tracks),) = library.tracks()
    for pattern in (BORDERING, f"head low or {BORDERING}"):
        asked = Expectation("it", pattern, parse(pattern), frozenset({"other"}))
        (result,) = evaluate([Clip(capture, tracks, None)], [asked], **how)
        assert result.found == (found,)
        assert [miss.hit.span.start for miss in result.misses if miss.hit] == [5] * found


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"tolerance": -1}, "a tolerance of -1 s"),
        ({"overlaps": "some"}, 'overlaps "some"'),
        ({"fuzzy": "many"}, '"many" edits'),
    ],
)
def test_what_makes_no_sense_is_told(library: Library, how, message: str) -> None:
    for ask in (library.search, library.suggest):
        with pytest.raises(UsageError, match=message):
            ask(BORDERING, **how)


def test_what_takes_too_long_says_how_far_it_came(library: Library) -> None:
    with pytest.raises(LanindexError, match="the search took longer than 0 s, and was through"):
        library.search("r_arm any", timeout=0)
    ((capture, tracks),) = library.tracks()
    asked = Expectation("it", BORDERING, parse(BORDERING), frozenset())
    with pytest.raises(LanindexError, match=r"evaluation took longer .* with 0 of 1 pat"):
        evaluate([Clip(capture, tracks, None)], [asked], timeout=0)


def test_it_is_told_how_far_a_search_is(library: Library) -> None:
    told = []
    library.store.session.progress = lambda *how_far: told.append(how_far)
    library.search("r_arm any")
    assert told
    assert {(noun, total) for noun, _, total in told} == {("captures", 1)}
