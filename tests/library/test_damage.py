"""Whatever happens to a library behind its back, it gives the same answers or says that it cannot.

Each change is one of: a cell set to something else, a bit of the file turned over, a row taken out
or put in twice.
"""

import random
import sqlite3
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from damaged_library import change_a_cell, put_a_row_in_twice, take_out_a_row, turn_a_bit
from effort import slow
from sample_library import ENCODING, sample_score, sql

from lanindex import records
from lanindex.errors import LibraryError
from lanindex.library.migrate import check
from lanindex.model import Meter, Score, Span, Track
from lanindex.pipeline.library import Library

pytestmark = pytest.mark.sqlite  # a library in a file

PATTERNS = ("r_arm right low -> r_forward mid", "head any with l_arm high", "r_arm 0.3s+ ... left")


@pytest.fixture
def whole(tmp_path):
    """Return a library with something in every column."""
    with Library.open(tmp_path / "whole.db", create=True) as library:
        for number in range(3):
            score = sample_score(number)
            heading = np.array([0.0, 10.5, 359.9], np.float32)
            tracks = dict(score.tracks)
            tracks["head"] = Track("head", tracks["head"].symbols, (Span(0, 20), Span(30, 60)))
            library.store.add(
                f"{number}.bvh",
                Score(score.rate, score.frames, score.meter, tracks, heading, ("// kept",)),
                format="bvh",
                sha256=f"{number:064}",
                encoding=ENCODING if number else None,
                label="walk",
                metadata={"who": "x", "take": str(number)},
                warnings=("its unit is a guess",),
            )
        library.store.cache.compact()
        again = library.score(2)
        library.store.add("1.bvh", again, format="bvh", sha256=f"{1:064}", encoding=ENCODING)
    with sql(tmp_path / "whole.db") as connection:
        connection.execute("INSERT INTO segment_old VALUES (?, 'x', 0)", (str(tmp_path),))
    return tmp_path / "whole.db"


def answers(path):
    """Return what each verb says of a library, the words or the error; the error of opening it."""
    try:
        with Library.open(path, readonly=True) as library:
            return {verb: told(library, ask) for verb, ask in VERBS.items()}
    except LibraryError as error:
        return {"open": error}


def told(library, ask):
    try:
        return ask(library)
    except LibraryError as error:
        return error


def found_by(pattern):
    return lambda library: [records.of_hit(hit) for hit in library.search(pattern)]


VERBS = {
    "list": lambda library: [repr(one) for one in library.captures()],
    "show": lambda library: [shown(library, number) for number in (1, 2, 3)],
    **{pattern: found_by(pattern) for pattern in PATTERNS},
    "parts": lambda library: library.parts(),
    "stats": lambda library: repr(
        replace(library.stats(), size=0)
    ),  # a file grows by what is put in
    "columns": lambda library: told_in_columns(*library.store.columns(["r_arm", "head", "tail"])),
    "tracks": lambda library: [told_of(*one) for one in library.tracks([2], ["head"])],
}


def shown(library, number):
    score, capture = library.score(number), library.capture(number)
    symbols = [records.of_row(capture, one) for one in score.symbols()]
    known = {part: (track.known, track.kind) for part, track in score.tracks.items()}
    return symbols, known, score.heading.tolist(), score.other, score.meter, score.rate


def told_of(capture, tracks):
    return capture.id, {part: track.symbols.tolist() for part, track in tracks.items()}


def told_in_columns(roster, columns):
    names = ("bounds", "cell", "runner", "margin", "start", "stop", "seen")
    told = {part: [getattr(one, name).tolist() for name in names] for part, one in columns.items()}
    return [one.tolist() for one in (roster.number, roster.frames, roster.rate)], told


def verdict(path, wanted):
    """Return what became of a change: same, told, or one of the two that must not be."""
    errors = 0
    for verb, found in answers(path).items():
        if isinstance(found, LibraryError):
            errors += bool(str(found).encode() and (found.remedy or found.wanted))
        elif found != wanted[verb]:
            return f"silent: {verb}"
    try:
        found = bool("".join(check(path)).encode())
    except LibraryError:
        found = True
    if errors:
        return "told" if found else "unfound by check"
    return "found by check alone" if found else "same"


CHANGES = (*[change_a_cell] * 4, *[turn_a_bit] * 3, take_out_a_row, put_a_row_in_twice)


def damage(whole, times, seed):
    """Return how often what became of a change."""
    choice = random.Random(seed)
    wanted, content = answers(whole), whole.read_bytes()
    path = whole.with_name("damaged.db")
    became: Counter[str] = Counter()
    while sum(became.values()) < times:
        path.write_bytes(content)
        state, change = choice.getstate(), choice.choice(CHANGES)
        try:
            change(path, choice)
        except sqlite3.IntegrityError:  # what the tables themselves refuse
            continue
        told = verdict(path, wanted)
        became[told] += 1
        assert told in ("same", "told", "found by check alone"), (seed, state[1][-1], change, told)
    return became


def test_no_change_is_silent(whole):
    times = 200 if slow() else 50
    became = damage(whole, times, 1)
    assert became["told"] > times / 4


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seed", range(2, 12))
def test_no_change_is_silent_at_length(whole, seed):
    print(damage(whole, 300, seed))


def test_no_row_is_taken_for_that_of_another_table(tmp_path):
    path = tmp_path / "some.db"
    with Library.open(path, create=True) as library:
        for _ in range(4):  # so that numbers of segments are not those of captures
            library.store.add("a.bvh", sample_score(1, length=90), format="bvh", sha256="0")
            library.store.cache.compact()
        wanted = library.score(1).tracks["head"].symbols.tolist()
    content, told = path.read_bytes(), 0
    pages = [content[first : first + 4096] for first in range(0, len(content), 4096)]
    asked = "SELECT rootpage FROM sqlite_master WHERE name = 'sqlite_autoindex_segment_column_1'"
    with sql(path) as connection:
        ((index,),) = connection.execute(asked).fetchall()
    for leaf in (at for at, page in enumerate(pages) if page[:1] == b"\n"):
        path.write_bytes(b"".join([*pages[:leaf], pages[index - 1], *pages[leaf + 1 :]]))
        try:
            with Library.open(path, readonly=True) as library:
                assert library.score(1).tracks["head"].symbols.tolist() == wanted
        except LibraryError:
            told += 1
    assert told


OTHERS = (
    "UPDATE track SET part = iif(part = 'r_arm', 'l_arm', 'r_arm')",
    "UPDATE track SET part = 'r_arm'",
    "UPDATE track SET part = 'torso'",
    "UPDATE track SET known = '[[0, 9]]'",
    "UPDATE track SET known = '[[0'",
    "UPDATE track SET kind = 99",
    "UPDATE track SET symbols = -1",
    "UPDATE track SET symbols = symbols - 1",
    "UPDATE track SET symbols = 1 << 60",
    "UPDATE track SET symbols = 'x'",
    "UPDATE track SET ordinal = ordinal + 7",
    "UPDATE track SET ordinal = -ordinal - 1",
    "UPDATE track SET checksum = 'x'",
    "DELETE FROM track",
)


@pytest.mark.parametrize("change", OTHERS)
def test_no_hit_is_told_of_another_track(tmp_path, change):
    path = tmp_path / "some.db"
    one, other = sample_score(1), sample_score(2).tracks["r_arm"].symbols
    tracks = {"r_arm": one.tracks["r_arm"], "l_arm": Track("l_arm", other, (Span(0, 60),))}
    with Library.open(path, create=True) as library:
        for number in range(3):
            score = Score(one.rate, one.frames, Meter(), tracks)
            library.store.add(f"{number}.bvh", score, format="bvh", sha256="0")
        library.store.cache.compact()
        wanted = library.search("r_arm left").numpy().tolist()
    with sql(path) as connection:
        connection.execute(f"{change} WHERE capture_id = 2 AND part IN ('r_arm', 'l_arm')")
    with Library.open(path, readonly=True) as library:
        hits = library.search("r_arm left")
        assert hits.numpy().tolist() == wanted  # they come from the columns
        with pytest.raises(LibraryError, match="capture 2 is damaged in the library"):
            list(hits)


REPAIRED = (
    "UPDATE symbol_code SET start = start + 7",
    "DELETE FROM symbol_code WHERE track = 1",
    "UPDATE track SET known = x'ff'",
    "DELETE FROM track WHERE capture_id = 2",
    "UPDATE capture SET frames = 'z'",
    "UPDATE capture SET heading = 3",
    "UPDATE capture SET label = 'x', checksum = 0",
    "DELETE FROM metadata",
    "UPDATE profile SET name = 'other'",
)


@pytest.mark.parametrize("change", REPAIRED)
def test_what_is_damaged_is_written_down_anew(whole, change):
    with sql(whole) as connection:
        connection.execute(change)
    assert check(whole) != []
    with Library.open(whole) as library:
        for number in range(3):
            library.store.add(
                f"{number}.bvh", sample_score(number), format="bvh", sha256="0", encoding=ENCODING
            )
        assert [capture.id for capture in library.captures()] == [1, 2, 3]
    assert check(whole) == []


def test_a_damaged_capture_can_be_removed_by_its_number(whole):
    with sql(whole) as connection:
        connection.execute("UPDATE capture SET frames = 'z' WHERE id = 2")
    with Library.open(whole) as library:
        with pytest.raises(LibraryError, match=r"capture 2 is damaged.*ingest --force"):
            library.captures()
        library.remove(2)
        assert [capture.id for capture in library.captures()] == [1, 3]
    assert check(whole) == []


def test_what_was_said_stays_when_the_rest_is_written_anew(whole):
    with sql(whole) as connection:
        connection.execute("UPDATE capture SET frames = 'z' WHERE id = 2")
        connection.execute("UPDATE capture SET label = 'x' WHERE id = 3")
    with Library.open(whole) as library:
        for number in (1, 2):
            library.store.add(f"{number}.bvh", sample_score(number), format="bvh", sha256="0")
        assert [one.label for one in library.captures()] == ["walk", "walk", ""]
        assert library.capture(2).metadata == {"who": "x", "take": "1"}
        assert library.capture(3).metadata == {}
        assert library.notes == ["2.bvh: its label or metadata were damaged, and are gone"]


def test_a_damaged_capture_is_not_known(whole):
    with sql(whole) as connection:
        connection.execute("UPDATE capture SET speed = x'ff' WHERE id = 2")
    with Library.open(whole) as library:
        assert [path[-5:] for path in library.store.known()] == ["0.bvh", "2.bvh"]
