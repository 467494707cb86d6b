"""Verbs read no more of a larger library than their answer needs."""

import random
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from operator import methodcaller
from pathlib import Path

import pytest
from effort import seeds
from sample_library import ENCODING, add_sample, fill, sample_score, sql

from lanindex.library import read
from lanindex.library.migrate import check
from lanindex.library.segments import read_spine
from lanindex.library.stats import count
from lanindex.library.store import Store
from lanindex.model import Meter, Score, Span, Track

pytestmark = pytest.mark.sqlite  # a library in a file

SIZES = (60, 300)
"""Captures of a small library, and of a large one."""

DEEPER = 200
"""Instructions that the deeper trees of the larger one may take."""


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    """Return two libraries of the same captures, the second with many more."""
    paths = []
    for size in SIZES:
        paths.append(tmp_path_factory.mktemp("grown") / f"{size}.db")
        fill(paths[-1], size)
        with Store.open(paths[-1]) as library:
            library.cache.compact()
    return paths


@contextmanager
def watched(path):
    """Open a library, and count the instructions that SQLite carries out; list its statements."""
    with Store.open(path, readonly=True) as library:
        steps, statements = [0], []

        def step():
            steps[0] += 1

        library.session.connection.set_progress_handler(step, 1)
        library.session.connection.set_trace_callback(statements.append)
        yield library, steps, statements


ONE = {
    "a number": methodcaller("capture", 5),
    "a path": methodcaller("capture", "4.bvh"),
    "a score": methodcaller("score", 5),
    "its symbols": lambda library: list(library.tracks([5])),
    "its encoding": methodcaller("encoding", "4.bvh"),
    "the parts": methodcaller("parts", checked=False),
}


@pytest.mark.parametrize("asked", ONE)
def test_one_capture_takes_no_longer_among_many(grown, asked):
    took = []
    for path in grown:
        with watched(path) as (library, steps, _):
            ONE[asked](library)
            took.append(steps[0])
    assert took[1] < took[0] + DEEPER


def test_the_end_of_a_path_is_looked_for_in_an_index(grown):
    with watched(grown[0]) as (library, _, statements):
        library.capture(f"{Path.cwd().name}/4.bvh")
        plans = [
            library.session.connection.execute(f"EXPLAIN QUERY PLAN {it}") for it in statements
        ]
        told = [row[3] for plan in plans for row in plan]
    assert not [line for line in told if line == "SCAN capture"]


def test_no_more_paths_are_read_than_a_shell_offers(grown):
    with Store.open(grown[1], readonly=True) as library:
        assert library.paths_starting("", 3) == ["0.bvh", "1.bvh", "10.bvh"]
        assert library.paths_starting("29", 20) == ["29.bvh", *(f"29{it}.bvh" for it in range(10))]
        assert library.paths_starting("%", 3) == library.paths_starting("5_", 3) == []
    with watched(grown[1]) as (library, steps, _):
        library.paths_starting("", 3)
        assert steps[0] < DEEPER


def test_counts_read_no_row_of_a_track_or_symbol(grown):
    with watched(grown[1]) as (library, steps, statements):
        found = library.stats()
        assert (found.captures, found.symbols) == (SIZES[1], SIZES[1] * 18)
        assert not [it for it in statements if " track" in it or "symbol_code" in it]
        assert steps[0] < 20 * DEEPER  # rows of captures would take more


def test_a_check_reads_the_rows_of_many_captures_at_once(grown, monkeypatch):
    read_symbols, batches = read.read_symbols, []
    monkeypatch.setattr(
        read, "read_symbols", lambda *asked, **how: batches.append(1) or read_symbols(*asked, **how)
    )
    assert check(grown[1]) == []
    assert len(batches) == 1


def changed_score(choice: random.Random) -> Score:
    """Return a score with parts that have no symbols, were not seen, or were seen for a while."""
    score = sample_score(choice.randrange(9), length=choice.randint(1, 8))
    symbols, tracks = score.tracks["r_arm"].symbols, {}
    for part in choice.sample(["r_arm", "head", "r_leg", "torso"], choice.randint(0, 4)):
        seen = ((Span(0, score.frames),), (), (Span(0, 3), Span(5, score.frames)))
        rows = symbols if choice.random() < 0.5 else symbols[:0]
        tracks[part] = Track(part, rows, choice.choice(seen))
    rate = Fraction(choice.choice((30, 60, Fraction(30000, 1001))))
    return Score(rate, score.frames, Meter(), tracks)


@pytest.mark.parametrize("seed", seeds(8))
def test_counts_are_those_of_the_rows_after_any_history(tmp_path, seed):
    choice = random.Random(seed)
    with Store.open(tmp_path / "some.db", create=True) as library:
        for turn in range(60):
            path, doing = f"{choice.randrange(12)}.bvh", choice.random()
            held = [it.path for it in library.captures()]
            if doing < 0.6 or path not in held:
                encoding = ENCODING if choice.random() < 0.7 else None
                library.add(
                    path, changed_score(choice), format=choice.choice(("bvh", "c3d")),
                    sha256="0", label=choice.choice(("walk", "run", "")), encoding=encoding,
                )  # fmt: skip
            elif doing < 0.8:
                library.remove(path)
            else:
                library.label(path, choice.choice(("walk", "bow")))
            if choice.random() < 0.3:
                library.cache.compact()
            with library.session.reading() as connection:
                wanted = count(connection, read_spine(connection, trusted=False), 7)
                assert count(connection, read_spine(connection), 7) == wanted, turn
            if turn % 20 == 0:
                assert library.stats().captures == wanted.captures
        assert library.session.notes == []


def test_counts_do_not_trust_what_is_out_of_date(tmp_path):
    fill(tmp_path / "some.db", 3)
    with Store.open(tmp_path / "some.db") as library:
        library.cache.compact()
        add_sample(library, 3)
        whole = library.stats()
    assert (whole.captures, whole.profiles) == (4, {"default": 4})
    with sql(tmp_path / "some.db") as connection:
        connection.execute("UPDATE segment_column SET content = x'00' WHERE name = 'totals'")
    with Store.open(tmp_path / "some.db") as library:
        assert library.stats() == whole
        library.columns(["head"])
        assert "damaged: totals of the captures in segment 1" in library.session.notes[0]
    with Store.open(tmp_path / "some.db") as library:
        assert replace(library.stats(), size=whole.size) == whole
        library.columns(["head"])
        assert library.session.notes == []


def test_counts_stored_with_segments_are_those_of_the_rows(tmp_path):
    fill(tmp_path / "some.db", 6)
    with Store.open(tmp_path / "some.db") as library:
        by_rows = library.stats()
        library.cache.compact()
        assert replace(library.stats(), size=by_rows.size) == by_rows
        library.remove(2)
        library.label(3, "walk")
        without = library.stats()
        assert (without.captures, without.labels["walk"]) == (5, 1)
        with sql(tmp_path / "some.db") as connection:
            connection.execute("DELETE FROM segment")
            connection.execute("UPDATE state SET columns = 0")
        assert replace(library.stats(), size=without.size) == without


def test_columns_of_some_captures_are_those_cut_from_all(tmp_path):
    fill(tmp_path / "some.db", 9)
    with Store.open(tmp_path / "some.db") as library:
        library.cache.compact()
        library.label(3, "walk")
        library.remove(5)
        library.cache.compact()
        library.label(1, "walk")
        parts, some = ["head", "r_arm", "r_hand"], [1, 2, 3, 5, 8]
        roster, columns = library.columns(parts, some, more=["swings"], kept=False)
        whole, by_part = library.columns(parts, some, more=["swings"])
        assert roster.same_as(whole)
        assert roster.number.tolist() == [1, 2, 3, 8]
        assert all(columns[part].same_as(by_part[part]) for part in parts)
