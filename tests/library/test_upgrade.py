"""An upgraded library of real captures equals one that is ingested anew.

``revision_0001.sql`` holds two choreographies of the corpus and a score, as revision 0001 kept
them.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from sample_library import sql

from lanindex.alphabet import PARTS
from lanindex.errors import LibraryError, LibraryVersionError
from lanindex.library import migrate
from lanindex.library.connect import altering, connected, target
from lanindex.library.selection import Selection
from lanindex.library.sqlite import SQLITE
from lanindex.pipeline.library import Library

pytestmark = pytest.mark.sqlite  # a library in a file


NAMES = ("jumping_jacks.bvh", "marching.bvh", "greetings.lnd")
DUMP = Path(__file__).with_name("revision_0001.sql")


@pytest.fixture
def old(tmp_path):
    with sql(tmp_path / "old.db") as connection:
        connection.executescript(DUMP.read_text(encoding="utf-8"))
    return tmp_path / "old.db"


SYMBOLS = """SELECT capture_id, part, ordinal, direction, level, start_frame, end_frame, tick,
 ticks, passing, rule, swings, round(margin, 3), runner_direction, runner_level
 FROM symbol ORDER BY capture_id, part, ordinal"""


def rows(path, question=SYMBOLS):
    with sql(path) as connection:
        return connection.execute(question).fetchall()


def test_an_old_library_is_refused_before_it_is_upgraded(old):
    with pytest.raises(LibraryVersionError, match="revision 0001, wanted 0005"):
        Library.open(old)


def test_the_view_shows_what_the_table_held(old):
    before = rows(old)
    tracks = rows(old, "SELECT capture_id, part FROM track ORDER BY capture_id, ordinal")
    assert migrate.upgrade(old).state == "current"
    assert rows(old) == before
    assert rows(old, "SELECT capture_id, part FROM track ORDER BY 1, ordinal") == tracks
    assert rows(old, "SELECT DISTINCT kind, amount FROM symbol") == [("gesture", None)]
    assert migrate.check(old) == []


def of_limbs(found):
    return [row for row in found if row[1] in PARTS]


def test_an_upgrade_makes_what_ingesting_anew_makes_of_limbs(old, tmp_path, repository):
    migrate.upgrade(old)
    folder = repository / "corpus"
    with Library.open(tmp_path / "new.db", create=True) as library:
        library.ingest(*(folder / name for name in NAMES), labels=folder / "labels.csv")
    assert rows(old) == of_limbs(rows(tmp_path / "new.db"))
    with Library.open(old) as before, Library.open(tmp_path / "new.db") as anew:
        digests = [[digest for digest, _ in it.store.known().values()] for it in (before, anew)]
        assert digests[0] == digests[1]
        for one, other in zip(before.captures(), anew.captures(), strict=True):
            assert (one.path, one.location) == (
                name := other.path.rsplit("/")[-1],
                f"/corpus/{name}",
            )
            assert (one.label, one.metadata, one.rate, one.frames, one.meter) == (
                *(other.label, other.metadata, other.rate, other.frames, other.meter),
            )
            found, wanted = before.score(one.id), anew.score(other.id)
            for part, track in found.tracks.items():
                assert track.known == wanted.tracks[part].known
            np.testing.assert_allclose(found.heading, wanted.heading, atol=0.101)
            assert found.other == wanted.other


def test_what_an_earlier_method_wrote_down_is_written_down_anew(old, tmp_path, repository):
    migrate.upgrade(old)
    folder = repository / "corpus"
    with Library.open(old) as library:
        done = library.ingest(*(folder / name for name in NAMES))
        assert [one.status for one in done] == ["added", "added", "unchanged"]
        *_, jacks = library.captures(Selection("*jumping_jacks.bvh"))
        assert "step" in library.score(jacks.id).tracks


def test_an_upgrade_makes_the_file_small(old):
    before = os.path.getsize(old)
    migrate.upgrade(old)
    assert os.path.getsize(old) < before / 1.05  # with empty tables, which take a page each


def test_numbers_go_on_after_an_upgrade(old):
    with sql(old) as connection:
        connection.execute("UPDATE capture SET id = 70 WHERE id = 3")
        for table in ("metadata", "track", "symbol"):
            connection.execute(f"UPDATE {table} SET capture_id = 70 WHERE capture_id = 3")
    migrate.upgrade(old)
    with Library.open(old) as library:
        library.remove(70)
        assert library.store.add("a.bvh", library.score(1), format="bvh", sha256="0") == 71


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("UPDATE symbol SET level = 'hihg' WHERE ordinal = 2", "capture 1 is damaged.*hihg"),
        ("UPDATE symbol SET swings = -1 WHERE ordinal = 2", "capture 1 is damaged.*no room"),
        ("UPDATE symbol SET margin = 'x' WHERE ordinal = 2", "capture 1 is damaged"),
        ("UPDATE track SET known = '[[0' WHERE capture_id = 2", "capture 2 is damaged"),
        ("UPDATE capture SET heading = 7 WHERE id = 2", "capture 2 is damaged"),
        ("DELETE FROM capture WHERE id = 2", "rows of the table metadata hang on nothing"),
        ("DELETE FROM track WHERE capture_id = 2", "rows of the table symbol hang on nothing"),
    ],
)
def test_a_damaged_library_stays_as_it_was(old, change, said):
    with sql(old) as connection:
        connection.execute(change)
    before = old.read_bytes()
    with pytest.raises(LibraryError, match=rf"{said}.*Nothing was changed"):
        migrate.upgrade(old)
    assert old.read_bytes() == before


def test_an_upgrade_that_cannot_make_the_file_smaller_is_one(old):
    link = connected(target(old), create=False, readonly=False, timeout=1)
    SQLITE.before_rebuilding(link)
    with altering(link) as connection:
        migrate.run(connection, "head", str(old))
    link.close()
    large = os.path.getsize(old)
    link = connected(target(old), create=False, readonly=False, timeout=0)
    with sql(old) as other:
        other.execute("BEGIN IMMEDIATE")  # another process writes meanwhile
        SQLITE.give_back_room(link)
    assert os.path.getsize(old) == large
    SQLITE.give_back_room(link)
    link.close()
    assert os.path.getsize(old) < large
    assert migrate.check(old) == []
