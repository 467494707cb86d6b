"""A library is copied into another database, and both answer alike."""

import pytest
from sample_library import add_sample, fill, name_of, sql

from lanindex.errors import LibraryError, UsageError
from lanindex.library import connect
from lanindex.library.copy import copy
from lanindex.library.migrate import check
from lanindex.library.store import Store
from lanindex.pipeline.library import open_library


@pytest.fixture
def in_file(tmp_path):
    """Return a library in SQLite, whatever the others are in, with captures that were removed."""
    name = f"sqlite:///{tmp_path / 'first.db'}"
    where = connect.Target(name, "", tmp_path / "first.db")
    with Store(connect.Session(where, create=True)) as store:
        for number in range(300):
            add_sample(store, number, label=f"no. {number % 3}", metadata={"who": "Ä"})
        store.remove(3, 300)
        store.move(7, "elsewhere/7.bvh")
        store.cache.compact()
    return where


def told(named):
    with open_library(named, readonly=True) as library:
        hits = library.search("head any").dicts()
        counts = library.search("r_arm any | count by clip.label").dicts()
        rest = library.store.known(), library.captures()
        scores = [library.score(number).tracks["head"].symbols.tolist() for number in (1, 299)]
        return hits, counts, rest, scores, library.notes


def test_there_and_back(in_file, tmp_path, monkeypatch):
    again, back = tmp_path / "again.db", tmp_path / "back.db"
    before = connect.in_file
    monkeypatch.setattr(
        connect, "in_file", lambda text: in_file if text == "first" else before(text)
    )
    seen = []
    count = copy("first", again, progress=lambda *it: seen.append(it))
    assert count == 298
    assert seen[0] == ("captures", 0, 298)
    assert ("captures", 298, 298) in seen
    assert copy(name_of(again), back) == 298
    wanted = told("first")
    for named in (again, back):
        assert told(named) == wanted
        assert check(named) == []
        with Store.open(named) as store:
            assert add_sample(store, 1000) == 301  # not that of a capture that was removed


def test_a_library_that_has_captures_is_no_target(tmp_path):
    fill(tmp_path / "a.db", 2)
    fill(tmp_path / "b.db", 1)
    with pytest.raises(UsageError, match="this library has 1 capture, wanted a new one"):
        copy(tmp_path / "a.db", tmp_path / "b.db")
    with pytest.raises(UsageError, match="onto itself"):
        copy(tmp_path / "a.db", tmp_path / "a.db")


def test_damage_is_not_copied(tmp_path):
    fill(tmp_path / "a.db", 3)
    with sql(tmp_path / "a.db") as connection:
        connection.execute("UPDATE symbol_code SET sign = sign + 1 WHERE capture_id = 2")
    with pytest.raises(LibraryError, match="capture 2 is damaged"):
        copy(tmp_path / "a.db", tmp_path / "b.db")
    with Store.open(tmp_path / "b.db") as store:
        assert store.captures() == []


@pytest.mark.parametrize("table", ["metadata", "symbol_code"])
def test_a_source_that_cannot_be_read_is_named(tmp_path, table):
    fill(tmp_path / "a.db", 3)
    with sql(tmp_path / "a.db") as connection:
        connection.execute(f"ALTER TABLE {table} RENAME TO other")
    with pytest.raises(LibraryError) as error:
        copy(tmp_path / "a.db", tmp_path / "b.db")
    assert error.value.place == str(tmp_path / "a.db")


def test_an_empty_library(tmp_path):
    fill(tmp_path / "a.db", 0)
    assert copy(tmp_path / "a.db", tmp_path / "b.db") == 0
    assert check(tmp_path / "b.db") == []
