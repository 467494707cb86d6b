"""A search in shards of a library finds what a search in one process finds, byte for byte."""

import json
import tomllib
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from random import Random

import pytest
from effort import seeds, slow
from generated_patterns import random_pattern
from in_shards import Here
from query_cases import cases
from random_library import DIRECTIONS, PARTS, WHOLE, random_library
from sample_library import fill, sample_score, sql

from lanindex.errors import LanindexError, LibraryError
from lanindex.library import cache, segments
from lanindex.library.selection import Selection
from lanindex.model import Meter, Score
from lanindex.pipeline import shards
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.movement import COUNTABLE_PARTS
from lanindex.search.hits import Hits

SHARDS = (1, 2, 7)
LABELS = ("bow", "wave", "")
PIPES = (
    "count",
    "count by clip.label",
    "count by clip.path",
    "count by match.length",
    "count by match.direction",
    "first 3",
    "sort by match.length | first 3",
    "sort by clip.label | first 5 | count by match.start",
)


@pytest.fixture(autouse=True)
def small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "FEWEST", 1)


def told(library: Library, pattern: str, **how: object) -> str:
    """Return all that a search tells: hits with their symbols or counts, notes, refusals."""
    library.notes.clear()
    library.refused.clear()
    try:
        found = library.search(pattern, **how)
        rest = [found.tally(), found.pattern] if isinstance(found, Hits) else []
        if isinstance(found, Hits):  # as --limit takes them
            rest += [some.dicts() for some in (found[:2], found.by_fit(2)[:2])]
        rest.append([hit.lines for hit in found] if isinstance(found, Hits) else found.total)
        answer = [found.dicts(), repr(rest)]
    except LanindexError as error:
        answer = [type(error).__name__, str(error)]
    return json.dumps([answer, library.notes, list(map(str, library.refused))])


def check(library: Library, pattern: str, **how: object) -> None:
    library.spread = None
    plain = told(library, pattern, **how)
    for tasks in SHARDS:
        library.spread = Here(tasks)
        assert told(library, pattern, **how) == plain, (pattern, how, tasks)
    library.spread = None


def made(path: Path, random: Random, parts: tuple[str, ...]) -> Library:
    """Make a library of several segments, some of whose captures are gone, changed, or in none."""
    library, number = open_library(path, create=True), 0
    for _ in range(4):
        for capture, tracks in random_library(random, captures=8, most=12, known=parts):
            number += 1
            score = Score(capture.rate, capture.frames, capture.meter, dict(tracks))
            label = random.choice(LABELS)
            how = {"format": "lnd", "sha256": f"{number:064}", "label": label}
            library.store.add(f"{random.randint(1, 40)}.lnd", score, **how)
        if random.random() < 0.8:
            library.store.cache.compact()
        if random.random() < 0.5:
            library.remove(random.choice(library.captures()).id)
    return library


@pytest.mark.parametrize("seed", seeds(10))
def test_shards_find_the_same(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if seed % 2:  # every batch a segment of its own
        monkeypatch.setattr(cache, "join", lambda connection: False)
    random = Random(seed)
    parts = tuple(random.sample(WHOLE, 4)) if seed % 3 == 1 else PARTS
    with made(tmp_path / "l.db", random, parts) as library:
        with library.store.session.reading() as connection:
            spine = segments.read_spine(connection)
        assert len(spine.segments) > 1 or not seed % 2
        for _ in range(40 if slow() else 4):
            text = random_pattern(random, parts=parts, directions=DIRECTIONS)
            how = {
                "tolerance": 0.2,
                "overlaps": random.choice(("all", "none")),
                "near": random.random() < 0.3,
                "best": random.choice((None, None, 1, 5)),
                "fuzzy": random.choice((None, None, "1", "20%")),
                "selection": random.choice((Selection(), Selection("*1*"), Selection("no"))),
            }
            check(library, text, **how)
            pipe = random.choice(PIPES)
            check(library, f"{text} | {pipe}", **how)
        for pipe in PIPES:
            check(library, f"r_arm any -> any | {pipe}", overlaps="all")
        texts = ("arm low -> high", "arm mid without head", "r_arm any", "arms low ... high")
        for text in texts if slow() else texts[seed : seed + 1]:
            for best in (None, 3):
                check(library, text, fuzzy="2", best=best)


def test_the_cases_of_the_language(tmp_path: Path) -> None:
    """All recordings of the page in one library."""
    every = [case for case in cases() if not case.error and "clip.nothing" not in case.pattern]
    with open_library(tmp_path / "l.db", create=True) as library:
        held = {id(case.recordings): case.recordings for case in every}
        for number, recordings in enumerate(held.values()):
            for one in recordings:
                how = {"format": "lnd", "sha256": "0" * 64, "metadata": one.capture.metadata}
                library.store.add(tmp_path / f"{number} {one.name}.lnd", one.score(), **how)
        library.store.cache.compact()
        for case in every[:: 1 if slow() else 100]:
            how = {"tolerance": float(case.tolerance), "overlaps": case.overlaps}
            check(library, case.pattern, **how)


@pytest.mark.slow
def test_real_patterns_in_real_captures(tmp_path: Path, captures: Path, repository: Path) -> None:
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest(captures / "bvh", labels=captures / "labels.csv", jobs=2)
        for name in ("labels", "mae", "bandai1", "bandai2"):
            table = (repository / "tests" / "benchmarks" / f"{name}.toml").read_text()
            for entry in [*tomllib.loads(table).values()][::3]:
                check(library, entry["pattern"])
                check(library, f"{entry['pattern']} | count by clip.label")
                with suppress(LanindexError):  # some have no edits
                    check(library, entry["pattern"], fuzzy="15%", best=10)
        for text in ("arm high | sort by match.length | first 9", "arm low ... high"):
            check(library, text, overlaps="all", near=True)


@pytest.mark.parametrize("seed", seeds(2))
def test_shards_count_the_same_movement(seed: int, tmp_path: Path) -> None:
    random = Random(seed)
    parts = [part for part in PARTS if part in COUNTABLE_PARTS]
    chosen = Selection(), Selection("*1*"), Selection("no")
    compared = {"by": "label", "compared": LABELS[:2]}
    with made(tmp_path / "l.db", random, PARTS) as library:
        for how in ({}, {"by": "label"}, compared, {"by": "path"}):
            for selection in chosen[: 1 if how is compared else 3]:
                answers = []
                for spread in (None, *map(Here, SHARDS)):
                    library.spread = spread
                    found = library.movement(selection, parts=parts, **how)
                    arrays = [
                        (it.cells.tolist(), it.transitions.tolist(), it.over_time.tolist())
                        for it in found.moves
                    ]
                    assert how is not compared or found.differences
                    answers.append((repr(found), arrays))
                assert answers[1:] == answers[:1] * 3, (how, selection)


@pytest.fixture
def library(tmp_path: Path):
    fill(tmp_path / "l.db", 30)
    with open_library(tmp_path / "l.db") as opened:
        opened.store.cache.compact()
        opened.spread = Here(3)
        yield opened


def test_what_is_found_so_far_is_told_in_order_of_capture(library: Library) -> None:
    job = library.begin("r_arm any")
    assert job.wait(60)
    assert job.state == "done"
    assert job.progress == ("captures", 30, 30)
    library.spread = None
    plain = library.begin("r_arm any")
    assert plain.wait(60)
    for order in ("", "best", "capture", "best capture"):
        wanted = [(hit.path, hit.span, hit.fit) for hit in plain.page(0, 20, order)]
        assert [(hit.path, hit.span, hit.fit) for hit in job.page(0, 20, order)] == wanted
    assert job.facets("path").dicts() == plain.facets("path").dicts()


def test_shards_are_about_as_long_and_follow_each_other(library: Library) -> None:
    with library.store.session.reading() as connection:
        found = shards.cut(connection, shards.Held(), ["r_arm"], None, 4)
        few = shards.cut(connection, shards.Held(), ["r_arm"], [3, 4, 29], 4)
    assert [(it.first, it.last) for it in found] == [(0, 8), (8, 15), (15, 23), (23, 30)]
    assert [(it.first, it.chosen.tolist()) for it in few] == [(0, [2, 3]), (23, [28])]
    assert {part for part, _ in found[0].segment.entries} == {"", "r_arm"}


def test_what_is_cut_is_read_anew_once_the_library_changes(library: Library) -> None:
    library.search("r_arm any")
    held = shards._own[library.store]
    before = held.held("kept", lambda: "before")
    library.search("r_arm high")
    assert held.held("kept", lambda: "after") == before
    library.remove(3)
    assert {hit.capture.id for hit in library.search("r_arm any")} == {*range(1, 31)} - {3}
    assert held.held("kept", lambda: "after") == "after"


def test_hits_are_those_of_the_library_that_was_searched(library: Library) -> None:
    hits = library.search("r_arm any -> any")
    library.label(1, "said later")
    assert hits[0].capture.label == "said later"
    hits = library.search("r_arm any -> any")
    score = sample_score(0)
    score.tracks["r_arm"].symbols.flags.writeable = True
    score.tracks["r_arm"].symbols["margin"][2] = 0.7
    library.store.add("0.bvh", score, format="bvh", sha256="0")
    with pytest.raises(LibraryError, match="gone, or others now"):
        hits[0]
    assert library.search("r_arm any -> any", Selection("0.bvh"))[0].start == hits[0:1].low[0]


def test_hits_are_made_after_the_library_is_closed(library: Library) -> None:
    hits = library.search("r_arm any")
    library.close()
    assert hits[3].symbols[0].part == "r_arm"


def test_a_library_that_changes_meanwhile_is_told(library: Library) -> None:
    with library.store.session.reading() as connection:
        (shard,) = shards.cut(connection, shards.Held(), ["r_arm"], None, 1)
    state = shards.State(library.store.session.target, library.stamp, 1, "")
    library.label(1, "changed")
    with pytest.raises(LibraryError, match=r"has changed while it was read\. Run again"):
        shards.columns_at(state, shard, ["r_arm"], (), lambda: None)


def test_damaged_columns_are_mended(library: Library, tmp_path: Path) -> None:
    wanted = len(library.search("r_arm any"))
    with sql(tmp_path / "l.db") as connection:
        connection.execute(
            "UPDATE segment_column SET content = zeroblob(length(content)) "
            "WHERE part = 'l_arm' AND name = 'cell'"
        )
    hits = library.search("l_arm any")
    assert "damaged" in library.notes[0]
    library.spread = None
    library.notes.clear()
    assert library.search("l_arm any").dicts() == hits.dicts()
    assert len(library.search("r_arm any")) == wanted
    assert library.notes == []


def test_captures_that_wait_are_put_into_a_segment(library: Library, monkeypatch) -> None:
    monkeypatch.setattr(shards, "MOST_PENDING", 2)
    for number in range(40, 50):
        library.store.add(
            f"{number}.bvh", Score(Fraction(30), 60, Meter(), sample_score().tracks),
            format="bvh", sha256="0",
        )  # fmt: skip
    assert library.search("r_arm any").captures == 40
    assert library.notes == [
        "the library's columns lack 10 of its captures: they are made of its symbols now"
    ]


def test_a_library_that_cannot_be_mended_is_read_from_its_rows(
    library: Library, tmp_path: Path, monkeypatch
) -> None:
    library.spread = None
    wanted = library.search("r_arm any").dicts()
    library.spread = Here(3)
    with sql(tmp_path / "l.db") as connection:
        connection.execute("UPDATE segment SET checksum = 0")
    monkeypatch.setattr(library.store.cache, "mend", lambda *_: None)
    assert library.search("r_arm any").dicts() == wanted
