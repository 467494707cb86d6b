"""Columns equal the rows of a library, whatever happens to its segments."""

import random
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest
from columns_told import PARTS, by_rows, cut, flip, found, given
from effort import slow
from sample_library import add_sample, fill, name_of, sample_score, sql

from lanindex.errors import LibraryError
from lanindex.library.migrate import check
from lanindex.library.store import Store


@pytest.fixture
def path(tmp_path):
    """Return a library with two segments, a dead capture and a pending one."""
    path = tmp_path / "some.db"
    fill(path, 6)
    with Store.open(path) as library:
        library.cache.compact()
        add_sample(library, 6)
        library.cache.compact()
        library.add("2.bvh", sample_score(8), format="bvh", sha256="1")
    with sql(path) as connection:
        asked = "SELECT (SELECT count(*) FROM segment), (SELECT count(*) FROM segment_dead)"
        assert connection.execute(asked).fetchall() == [(2, 1)]
    return path


def test_segments_are_believed(path):
    assert found(path) == (by_rows(path), [])


def damage(path, choice):
    """Change one value, or take out a row, or put one in; return whether it must be noticed."""
    table, column = choice.choice(
        [
            *[("segment_column", "content")] * 8,
            ("segment_column", "segment_id"),
            ("segment_column", "part"),
            ("segment_column", "name"),
            ("segment", "listing"),
            ("segment", "captures"),
            ("segment", "symbols"),
            ("segment", "checksum"),
            ("segment_dead", "capture_id"),
            ("segment_dead", "segment_id"),
            ("segment_pending", "capture_id"),
            ("state", "columns"),
        ]
    )
    with closing(sqlite3.connect(path)) as connection, connection:
        # these are read only to count a segment of which captures are dead
        unread = " WHERE NOT (segment_id = 2 AND name IN ('profile', 'still'))"
        unread *= table == "segment_column"
        rows = connection.execute(f"SELECT rowid, {column} FROM {table}{unread}").fetchall()
        row, value = choice.choice(rows)
        if table != "state" and choice.random() < 0.2:
            connection.execute(f"DELETE FROM {table} WHERE rowid = ?", (row,))
            return True
        if isinstance(value, int):
            other = choice.choice([value + 1, value - 1, value ^ 1 << choice.randrange(40)])
        else:
            text = value if isinstance(value, bytes) else value.encode()
            other = choice.choice([flip, cut])(text, choice) if text else b"x"
        is_text = isinstance(value, str)
        new = "CAST(? AS TEXT)" if is_text else "?"
        connection.execute(f"UPDATE {table} SET {column} = {new} WHERE rowid = ?", (other, row))
    return (table, column) != ("segment_dead", "segment_id")


def damaged(path, times, seed):
    choice, whole, wanted = random.Random(seed), path.read_bytes(), by_rows(path)
    noticed = 0
    while noticed < times:
        path.write_bytes(whole)
        state = choice.getstate()[1][-1]
        try:
            must = damage(path, choice)
        except sqlite3.IntegrityError:
            continue
        answer, notes = found(path)
        assert answer == wanted, (seed, state)
        assert notes or not must, (seed, state)
        noticed += bool(notes)
        assert found(path) == (wanted, []), (seed, state)
        assert check(path) == []


@pytest.mark.sqlite
def test_no_damage_is_believed(path):
    damaged(path, 100 if slow() else 30, 1)


@pytest.mark.sqlite
@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seed", range(2, 11))
def test_no_damage_is_believed_at_length(path, seed):
    damaged(path, 100, seed)


@pytest.mark.sqlite
def test_damage_is_told_and_mended(path):
    with sql(path) as connection:
        connection.execute("UPDATE segment_column SET content = x'00' WHERE name = 'cell'")
    _, (note,) = found(path)
    assert note == (
        "the library's columns were damaged: cell of r_arm in segment 1: they are made of its "
        "symbols now"
    )


def test_what_another_program_changed_is_seen(path):
    with sql(path) as connection:
        connection.execute("DELETE FROM symbol_code WHERE capture_id = 4")
        connection.execute("DELETE FROM track WHERE capture_id = 4")
        connection.execute("DELETE FROM capture WHERE id = 4")
        connection.execute("UPDATE state SET stamp = stamp + 1, captures = 6, numbers = 24")
    answer, (note,) = found(path)
    assert answer == by_rows(path)
    assert "out of date, for another program has changed the library" in note
    assert found(path) == (by_rows(path), [])


def test_a_capture_is_stored_even_where_it_was_said_to_wait(path):
    with sql(path) as connection:
        connection.execute("INSERT INTO segment_pending VALUES (8)")
    with Store.open(path) as library:
        assert add_sample(library, 7) == 8
    assert found(path) == (by_rows(path), [])


def test_a_capture_that_waits_and_is_gone_is_missed_by_counts(path):
    with sql(path) as connection:
        connection.execute("DELETE FROM capture WHERE id = 3")
    with (
        Store.open(path, readonly=True) as library,
        pytest.raises(LibraryError, match="the library holds 6 captures"),
    ):
        library.stats()


def test_a_library_held_open_sees_what_others_change(path):
    with Store.open(path, readonly=True) as library:
        library.columns(PARTS)
        with Store.open(path) as other:
            other.remove(1)
            other.cache.compact()
        assert given(library) == by_rows(path)
        assert library.session.notes == []


@pytest.mark.sqlite
def test_a_page_that_cannot_be_read_is_no_matter_where_the_rows_are_whole(path, monkeypatch):
    with sql(path) as connection:
        asked = "SELECT rootpage FROM sqlite_master WHERE name = 'segment_column'"
        ((page,),) = connection.execute(asked).fetchall()
    wanted, content = by_rows(path), bytearray(path.read_bytes())
    content[(page - 1) * 4096 : page * 4096] = b"\xff" * 4096
    path.write_bytes(content)
    answer, notes = found(path)
    assert answer == wanted
    assert "cannot be read" in notes[0]
    assert notes[1] == CANNOT.format("the library is damaged")


CANNOT = (
    "the library's columns cannot be written ({}): what is not there is read from the symbols, "
    "each time"
)


@pytest.mark.sqlite
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("", []),
        ("UPDATE state SET stamp = 70", ["out of date"]),
        ("DELETE FROM segment", ["they are not those of the captures that there are"]),
    ],
)
def test_a_library_that_may_not_be_written(folder, common_user, change, said):
    path = folder / "some.db"
    fill(path, 3)
    with Store.open(path) as library:
        library.cache.compact()
        add_sample(library, 3)
    with sql(path) as connection:
        connection.execute(change)
    wanted = by_rows(path)
    path.chmod(0o444)
    folder.chmod(0o555)
    with common_user():
        answer, notes = found(path)
    assert answer == wanted
    assert notes[1:] == [CANNOT.format("the library or its folder may not be written")] * len(said)
    assert [word for word in said if word in notes[0]] == said


def test_many_captures_that_wait_are_put_into_a_segment_by_a_search(path, monkeypatch):
    monkeypatch.setattr("lanindex.library.cache.MOST_PENDING", 0)
    assert found(path) == (
        by_rows(path),
        ["the library's columns lack 1 of its captures: they are made of its symbols now"],
    )
    assert found(path) == (by_rows(path), [])
    with sql(path) as connection:
        assert connection.execute("SELECT count(*) FROM segment_pending").fetchall() == [(0,)]


@pytest.mark.sqlite
def test_many_captures_that_wait_while_another_process_writes(path, monkeypatch):
    monkeypatch.setattr("lanindex.library.cache.MOST_PENDING", 0)
    monkeypatch.setattr("lanindex.library.cache._WRITE_TIMEOUT", 0)
    wanted = by_rows(path)
    with Store.open(path, readonly=True) as library, closing(sqlite3.connect(path)) as other:
        other.execute("BEGIN IMMEDIATE")
        for _ in range(2):
            assert given(library) == wanted
        assert library.session.notes[1:] == [CANNOT.format("another process holds the library")]


def test_a_library_in_memory_has_columns():
    with Store.open(":memory:", create=True) as library:
        add_sample(library, 1)
        library.cache.compact()
        assert len(library.columns(PARTS)[1]["head"]) == 6


def test_a_damaged_capture_is_told_not_laundered(path):
    with sql(path) as connection:
        connection.execute("UPDATE symbol_code SET start = start + 1 WHERE capture_id = 5")
        connection.execute("UPDATE state SET columns = -1")
    with pytest.raises(LibraryError, match="capture 5 is damaged in the library: its track"):
        found(path)
    with Store.open(path) as library:
        library.cache.compact()
        assert "capture 5 is damaged" in library.session.notes[0]
        add_sample(library, 4)
    assert found(path) == (by_rows(path), [])


BROKEN_OFF = """
import os, signal, sys
sys.path[:0] = [sys.argv[2]]
from sample_library import add_sample
from lanindex.library import segments
from lanindex.library.store import Store

def last_word(*_):
    os.kill(os.getpid(), signal.SIGKILL)

setattr(segments, sys.argv[3], last_word)
with Store.open(sys.argv[1]) as library:
    if library.session.target.path:
        library.session.connection.execute("PRAGMA cache_spill = 1")
        library.session.connection.execute("PRAGMA cache_size = 2")
    for number in range(7, 12):
        add_sample(library, number)
    library.cache.compact()
"""


@pytest.mark.parametrize("moment", ["mark_covered", "drop_part", "drop"])
def test_killed_while_a_segment_is_written_or_joined(path, repository, moment, database):
    command = [sys.executable, "-c", BROKEN_OFF, name_of(path), str(repository / "tests"), moment]
    assert subprocess.run(command).returncode == -9
    if database == "sqlite":
        assert path.with_name(path.name + "-journal").stat().st_size > 0
    answer, notes = found(path)
    assert (answer, notes) == (by_rows(path), [])
    assert check(path) == []
    with Store.open(path) as library:
        library.cache.compact()
    assert found(path) == (by_rows(path), [])


INGEST = """
import sys
sys.path[:0] = [sys.argv[2]]
from sample_library import add_sample
from lanindex.library.store import Store
with Store.open(sys.argv[1]) as library:
    for number in range(7, 70):
        add_sample(library, number)
        if number % 5 == 0:
            library.cache.compact()
"""


def test_two_searches_during_an_ingest(path, repository):
    command = [sys.executable, "-c", INGEST, name_of(path), str(repository / "tests")]
    alone = {part: sample_score(0).tracks[part].symbols for part in PARTS[:3]}
    seen = set()
    with subprocess.Popen(command) as ingest:
        with Store.open(path, readonly=True) as one, Store.open(path, readonly=True) as other:
            while len(seen) < 2 or ingest.poll() is None:
                for library in (one, other):
                    roster, columns = library.columns(PARTS)
                    seen.add(len(roster))
                    assert roster.number.tolist() == list(range(1, len(roster) + 1))
                    for part, symbols in alone.items():
                        whole = np.tile(symbols["start"], len(roster))
                        assert columns[part].start.tolist() == whole.tolist()
            assert (one.session.notes, other.session.notes) == ([], [])
        assert ingest.wait() == 0
    assert found(path) == (by_rows(path), [])
    assert [*path.parent.iterdir()] in ([], [path])  # it is in a server, or one file
