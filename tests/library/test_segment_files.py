"""Searches find the same with the columns in files, whatever happens to the files."""

import json
import os
import random
import signal
import subprocess
import sys
import uuid

import fsspec
import numpy as np
import pytest
from columns_told import PARTS, by_rows, cut, flip, found, given
from effort import seeds
from generated_patterns import random_pattern
from in_shards import Here
from random_library import DIRECTIONS, random_library
from random_library import PARTS as KNOWN
from sample_library import add_sample, fill, sql

from lanindex import records
from lanindex.errors import LibraryError, UsageError
from lanindex.library import segment_files, segments
from lanindex.library.migrate import check, files_of_columns, keep_columns
from lanindex.library.rows import checksum
from lanindex.library.store import Store
from lanindex.model import Score
from lanindex.pipeline import shards
from lanindex.pipeline.library import Library

pytestmark = pytest.mark.sqlite  # a library in a file


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Keep copies of this test's own."""
    monkeypatch.setenv("LANINDEX_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "segments"


@pytest.fixture
def inside(tmp_path):
    """Return a library with two segments, a dead capture and a pending one."""
    path = tmp_path / "some.db"
    fill(path, 6)
    with Store.open(path) as library:
        library.cache.compact()
        add_sample(library, 6)
        library.cache.compact()
        library.remove(3)
        add_sample(library, 7)
    return path


@pytest.fixture
def path(inside):
    """Return the same library with its columns in the folder ``cols`` beside it."""
    keep_columns(inside, "cols")
    return inside


@pytest.fixture
def bucket():
    """Return the URL of a bucket in memory."""
    return f"memory://{uuid.uuid4().hex}/cols"


def files(path):
    return sorted((path.parent / "cols").iterdir())


def count(path, table):
    with sql(path) as connection:
        return connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0]


PATTERNS = ("r_arm right low -> r_forward mid", "head any with l_arm high", "r_arm 0.3s+ ... left")


def hits(path, spread=None):
    with Library.open(path, readonly=True) as library:
        library.spread = spread
        return [[records.of_hit(hit) for hit in library.search(one)] for one in PATTERNS]


@pytest.mark.parametrize("where", ["cols", "bucket"])
def test_there_and_back(inside, where, bucket):
    wanted, hit = found(inside), hits(inside)
    keep_columns(inside, bucket if where == "bucket" else where)
    assert found(inside) == wanted == (by_rows(inside), [])
    assert hits(inside) == hit
    assert all(hit)
    assert count(inside, "segment_column") == 0
    place, number, size = files_of_columns(inside)
    assert number == len(segment_files.shelf_of(place).names()) == 2
    with Store.open(inside, readonly=True) as library:
        assert library.stats().size == inside.stat().st_size + size
    assert check(inside) == []
    keep_columns(inside, "")
    assert found(inside) == wanted
    assert files_of_columns(inside) == ("", 0, 0)
    assert segment_files.shelf_of(place).names() == []
    assert check(inside) == []


def told(path, patterns, spread=None):
    with Library.open(path, readonly=True) as library:
        library.spread = spread
        return [library.search(one).dicts() for one in patterns]


@pytest.mark.parametrize("seed", seeds(3))
def test_a_search_finds_the_same_wherever_the_columns_are(tmp_path, seed, monkeypatch):
    monkeypatch.setattr(segments, "BLOCK", 64)
    monkeypatch.setattr(shards, "FEWEST", 1)
    choice, path = random.Random(seed), tmp_path / "some.db"
    with Store.open(path, create=True) as library:
        for capture, tracks in random_library(choice, captures=20, most=12, known=KNOWN):
            score = Score(capture.rate, capture.frames, capture.meter, dict(tracks))
            library.add(f"{choice.randint(1, 15)}.lnd", score, format="lnd", sha256="0")
            if choice.random() < 0.3:
                library.cache.compact()
    patterns = [random_pattern(choice, parts=KNOWN, directions=DIRECTIONS) for _ in range(5)]
    wanted = told(path, patterns)
    keep_columns(path, "cols")
    assert told(path, patterns) == told(path, patterns, Here(3)) == wanted


def test_from_a_folder_to_another(path):
    keep_columns(path, (path.parent / "other").as_uri())
    assert files(path) == []
    assert len(list((path.parent / "other").iterdir())) == 2
    assert found(path) == (by_rows(path), [])


def test_shards(path, monkeypatch):
    monkeypatch.setattr(shards, "FEWEST", 1)
    assert hits(path, Here(3)) == hits(path)
    assert all(hits(path))


def test_what_an_earlier_version_listed_can_be_moved(inside):
    with sql(inside) as connection:
        rows = connection.execute("SELECT id, captures, symbols, listing FROM segment").fetchall()
        for number, captures, symbols, listing in rows:
            old = json.dumps([entry[:5] for entry in json.loads(listing)])
            change = "UPDATE segment SET listing = ?, checksum = ? WHERE id = ?"
            connection.execute(change, (old, checksum(captures, symbols, old), number))
    assert found(inside) == (by_rows(inside), [])
    keep_columns(inside, "cols")
    assert found(inside) == (by_rows(inside), [])


def test_an_ingest_writes_files_and_deletes_those_that_it_joined(path):
    with Store.open(path) as library:
        for number in range(8, 20):
            add_sample(library, number)
            library.cache.compact()
        assert given(library) == by_rows(path)
    assert len(files(path)) == count(path, "segment") < 5
    assert count(path, "segment_old") == count(path, "segment_column") == 0


def cut_short(file, other):
    file.write_bytes(file.read_bytes()[:-9])


def turn_over(file, other):
    file.write_bytes(bytes(255 - byte for byte in file.read_bytes()))


def swap(file, other):
    one, two = file.read_bytes(), other.read_bytes()
    file.write_bytes(two)
    other.write_bytes(one)


def empty(file, other):
    file.write_bytes(b"")


def delete(file, other):
    file.unlink()


@pytest.mark.parametrize("change", [cut_short, turn_over, swap, empty, delete])
def test_a_damaged_file_is_told_and_mended(path, change):
    change(*files(path))
    (told,) = check(path)
    assert "cols/" in told
    assert told.endswith(".columns. They are made anew by: lanindex db upgrade") or (
        "is not what its name says. They are made anew by: lanindex db upgrade" in told
    )
    answer, notes = found(path)
    assert answer == by_rows(path)
    assert "the library's columns were damaged" in notes[0]
    assert found(path) == (by_rows(path), [])
    assert check(path) == []


def test_no_damage_of_a_file_is_believed(path):
    choice, whole = random.Random(3), path.read_bytes()
    contents = {file: file.read_bytes() for file in files(path)}
    for _ in range(20):
        path.write_bytes(whole)
        for file, content in contents.items():
            file.write_bytes(content)
        file = choice.choice(list(contents))
        file.write_bytes(choice.choice([flip, cut])(contents[file], choice))
        assert check(path) != []
        assert found(path)[0] == by_rows(path)


def test_a_place_out_of_reach_is_left_as_it_is(path):
    folder, away = path.parent / "cols", path.parent / "away"
    folder.rename(away)
    (told,) = check(path)
    assert told.startswith(f"the columns are out of reach: there is no folder {folder}")
    assert told.endswith("lanindex db segments --inside")
    answer, notes = found(path)
    assert answer == by_rows(path)
    assert "out of reach" in notes[0]
    assert notes[1:] == [
        "the library's columns are left as they are: what is not there is read from the symbols, "
        "each time"
    ]
    assert not folder.exists()
    away.rename(folder)
    assert found(path) == (by_rows(path), [])
    away.mkdir()
    for file in files(path):
        file.rename(away / file.name)
    folder.rmdir()
    keep_columns(path, "")
    assert found(path) == (by_rows(path), [])


KILLED = """
import os, signal, sys
sys.path[:0] = [sys.argv[2]]
from sample_library import add_sample
from lanindex.library import segments
from lanindex.library.store import Store

segments._describe = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
with Store.open(sys.argv[1]) as library:
    add_sample(library, 20)
    library.cache.compact()
"""


def test_killed_between_the_file_and_the_commit(path, repository):
    before = files(path)
    command = [sys.executable, "-c", KILLED, str(path), str(repository / "tests")]
    assert subprocess.run(command).returncode == -signal.SIGKILL
    (loose,) = {*files(path)} - {*before}
    assert found(path) == (by_rows(path), [])
    with Store.open(path) as library:
        add_sample(library, 21)
        library.cache.compact()
        assert loose in files(path)  # somebody may be about to name it
        os.utime(loose, (0, 0))
        add_sample(library, 22)
        library.cache.compact()
    assert loose not in files(path)
    assert found(path) == (by_rows(path), [])


MOVED = """
import os, signal, sys
from lanindex.library import segment_files
from lanindex.library.migrate import keep_columns

segment_files.set_place = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
keep_columns(sys.argv[1], "cols")
"""


def test_killed_while_the_columns_move(inside):
    command = [sys.executable, "-c", MOVED, str(inside)]
    assert subprocess.run(command).returncode == -signal.SIGKILL
    assert files(inside) != []
    assert found(inside) == (by_rows(inside), [])
    keep_columns(inside, "cols")
    assert len(files(inside)) == count(inside, "segment")
    assert found(inside) == (by_rows(inside), [])
    assert count(inside, "segment_old") == 0


def test_what_a_reader_needs_stays(path):
    with sql(path) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
    before, wanted = files(path), by_rows(path)
    with Store.open(path, readonly=True) as reader, reader.session.reading() as connection:
        spine = segments.read_spine(connection)
        with Store.open(path) as writer:
            for number in range(8, 16):
                add_sample(writer, number)
                writer.cache.compact()
        assert {*before} < {*files(path)}
        roster, _ = segments.read_all_columns(connection, spine, dict.fromkeys(PARTS, ()))
        assert roster.number.tolist() == wanted[0][0]
    with sql(path) as connection:
        connection.execute("UPDATE segment_old SET since = since - 3601")
    with Store.open(path) as writer:
        writer.cache._mend("")
    assert {*before}.isdisjoint(files(path))
    assert found(path) == (by_rows(path), [])


def test_a_reader_keeps_a_rollback_journal_from_taking_files_out(path):
    before, wanted = files(path), by_rows(path)
    with Store.open(path, readonly=True) as reader, reader.session.reading() as connection:
        spine = segments.read_spine(connection)
        with Store.open(path, timeout=0.1) as writer:
            writer.cache._mend("")
            assert "another process holds the library" in writer.session.notes[0]
        assert {*before} <= {*files(path)}
        roster, _ = segments.read_all_columns(connection, spine, dict.fromkeys(PARTS, ()))
        assert roster.number.tolist() == wanted[0][0]


INGEST = """
import sys
sys.path[:0] = [sys.argv[2]]
from sample_library import add_sample
from lanindex.library.store import Store
with Store.open(sys.argv[1]) as library:
    for number in range(8, 30):
        add_sample(library, number)
        library.cache.compact()
"""


def test_searches_during_an_ingest_of_another_process(path, repository):
    command = [sys.executable, "-c", INGEST, str(path), str(repository / "tests")]
    with subprocess.Popen(command) as ingest, Store.open(path, readonly=True) as library:
        while ingest.poll() is None:
            roster, columns = library.columns(PARTS)
            assert columns["head"].bounds.tolist() == [6 * it for it in range(len(roster) + 1)]
        assert library.session.notes == []
    assert found(path) == (by_rows(path), [])
    assert check(path) == []


@pytest.mark.parametrize("change", ["", "DELETE FROM segment WHERE id = 1"])
def test_a_folder_that_may_not_be_written(folder, common_user, change):
    path = folder / "some.db"
    fill(path, 3)
    keep_columns(path, "cols")
    with sql(path) as connection:
        connection.execute(change)
    wanted = by_rows(path)
    path.chmod(0o666)
    (folder / "cols").chmod(0o555)
    with common_user():
        answer, notes = found(path)
    assert answer == wanted
    assert len(notes) == 2 * bool(change)
    assert all("columns cannot be written (Permission denied)" in note for note in notes[1:])


@pytest.fixture
def small_disk(tmp_path):
    """Mount a file system of 8 kB as the folder ``cols``, where that is allowed."""
    (tmp_path / "cols").mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=8k", "lanindex", str(tmp_path / "cols")]
    mounted = subprocess.run(command, capture_output=True, text=True)
    if mounted.returncode:
        pytest.skip(f"no right to mount a small disk: {mounted.stderr.strip()}")
    yield tmp_path / "cols"
    subprocess.run(["umount", str(tmp_path / "cols")], check=True)


def test_a_full_disk(small_disk, tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    keep_columns(path, "cols")
    with Store.open(path) as library:
        for number in range(1, 60):
            add_sample(library, number)
        library.cache.compact()
        assert "columns cannot be written (No space left" in library.session.notes[0]
    assert len(files(path)) == count(path, "segment") == 1  # and no draft
    assert found(path) == (by_rows(path), [])
    keep_columns(path, "")
    with pytest.raises(LibraryError, match="No space left on device"):
        keep_columns(path, "cols")
    assert files_of_columns(path) == ("", 0, 0)
    assert found(path) == (by_rows(path), [])


def test_a_file_that_cannot_be_read_again_is_not_kept(inside, monkeypatch):
    def unlike(*_):
        raise segment_files.Distrust("damaged: it is not what was written")

    with monkeypatch.context() as patch:
        patch.setattr(segment_files.Folder, "check", unlike)
        keep_columns(inside, "cols")
    assert len(files(inside)) == count(inside, "segment") == 1  # made anew
    assert found(inside) == (by_rows(inside), [])


@pytest.mark.parametrize("where", ["a\nb", "a\udcff"])
def test_a_name_that_cannot_be_told_is_refused(inside, where):
    with pytest.raises(UsageError, match="cannot be printed"):
        keep_columns(inside, where)
    assert found(inside) == (by_rows(inside), [])


def test_a_place_belongs_to_one_library(path, tmp_path):
    fill(tmp_path / "other.db", 1)
    with pytest.raises(UsageError, match="2 files of segments that this library does not name"):
        keep_columns(tmp_path / "other.db", "cols")
    assert files_of_columns(tmp_path / "other.db") == ("", 0, 0)
    assert found(path) == (by_rows(path), [])


def test_a_stretch_is_read_without_the_rest(tmp_path, monkeypatch):
    monkeypatch.setattr(segments, "BLOCK", 8)
    path = tmp_path / "some.db"
    fill(path, 7)
    keep_columns(path, "cols")
    with Store.open(path, readonly=True) as library, library.session.reading() as connection:
        (one,) = segments.read_spine(connection).segments
    whole = {part: segments.read_columns(None, one, part) for part in PARTS[:3]}
    roster = segments.read_roster(None, one)
    for captures in ((0, 2), (2, 5), (4, 4), (0, one.captures)):
        places = np.arange(*captures)
        assert segments.read_roster(None, one, captures).same_as(roster.at(places))
        for part, columns in whole.items():
            stretch = segments.read_columns(None, one, part, captures=captures)
            assert stretch.same_as(columns.at(places))
            assert stretch.rows == columns.rows
    (file,) = files(path)
    entry = one.entries["head", "cell"]
    with open(file, "r+b") as changed:
        changed.seek(entry.begin + entry.size - 1)
        changed.write(b"\xee")
    part = segments.read_columns(None, one, "head", captures=(0, 2))
    assert part.same_as(whole["head"].at(np.arange(2)))
    with pytest.raises(segment_files.Distrust, match="cell of head"):
        segments.read_columns(None, one, "head")


def test_copies_of_a_bucket(inside, bucket, cache, monkeypatch):
    keep_columns(inside, bucket)
    shelf = segment_files.shelf_of(bucket)
    for copy in cache.glob("*.columns"):
        copy.unlink()
    assert found(inside) == (by_rows(inside), [])
    copies = sorted(cache.glob("*.columns"))
    assert [copy.name for copy in copies] == sorted(shelf.names())
    turn_over(*copies)  # a damaged copy is fetched again
    copies[1].write_bytes(b"short")
    assert found(inside) == (by_rows(inside), [])
    monkeypatch.setattr(segment_files, "MOST_CACHED", 1)
    copies[0].unlink(missing_ok=True)
    assert found(inside) == (by_rows(inside), [])
    assert len(list(cache.glob("*.columns"))) == 1
    monkeypatch.setenv("LANINDEX_CACHE", str(inside))  # there is no room for copies
    assert found(inside) == (by_rows(inside), [])


def test_a_damaged_file_in_a_bucket_is_mended_where_there_is_a_whole_copy(inside, bucket, cache):
    keep_columns(inside, bucket)
    shelf = segment_files.shelf_of(bucket)
    name = shelf.names()[0]
    fsspec.filesystem("memory").pipe_file(f"{bucket}/{name}", b"other")
    assert found(inside) == (by_rows(inside), [])  # of the copy
    assert f"{bucket}/{name} is not what its name says" in check(inside)[0]
    shelf.forget(name)
    answer, notes = found(inside)
    assert (answer, "damaged" in notes[0]) == (by_rows(inside), True)
    assert found(inside) == (by_rows(inside), [])
    assert check(inside) == []


def test_a_bucket_out_of_reach_is_not_tried_again_and_again(inside, bucket, cache, monkeypatch):
    keep_columns(inside, bucket)
    for copy in cache.glob("*.columns"):
        copy.unlink()
    shelf, tried = segment_files.shelf_of(bucket), []

    def unreachable(*_, **__):
        tried.append(1)
        raise ConnectionError("no route")

    with monkeypatch.context() as patch:
        patch.setattr(shelf, "_until", 0.0)
        for name in ("open", "cat_file", "ls"):
            patch.setattr(fsspec.filesystem("memory"), name, unreachable)
        answer, notes = found(inside)
    assert (answer, len(tried)) == (by_rows(inside), 1)
    assert f"out of reach: {bucket}: no route" in notes[0]
    assert found(inside) == (by_rows(inside), [])


def test_a_bucket_that_nobody_knows(inside):
    with pytest.raises(LibraryError, match="fsspec knows no nowhere://"):
        keep_columns(inside, "nowhere://bucket")
    assert found(inside) == (by_rows(inside), [])


def test_a_bucket_without_the_package_for_it(inside, monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    with pytest.raises(LibraryError, match=r"pip install 'lanindex\[remote\]'"):
        keep_columns(inside, "memory://without")


def test_columns_that_cannot_be_trusted_are_made_anew_where_they_go(inside):
    with sql(inside) as connection:
        connection.execute("UPDATE segment SET file = 'x'")
    keep_columns(inside, "cols")
    assert len(files(inside)) == 1
    assert found(inside) == (by_rows(inside), [])
    assert check(inside) == []


def test_loose_files_of_a_bucket_go_by_its_own_clock(inside, bucket, monkeypatch):
    keep_columns(inside, bucket)
    shelf = segment_files.shelf_of(bucket)
    loose = shelf.write([b"loose"])
    for spared in (3600, -1):
        monkeypatch.setattr(segment_files, "_SPARED", spared)
        with Store.open(inside) as library:
            library.cache._mend("")
        assert (loose in shelf.names()) == (spared > 0)
    assert found(inside) == (by_rows(inside), [])


def test_no_name_from_a_library_leads_elsewhere(path, tmp_path):
    (tmp_path / "mine").write_text("mine")
    with sql(path) as connection:
        connection.execute("INSERT INTO segment_old VALUES (?, 'mine', 0)", (str(tmp_path),))
    with Store.open(path) as library:
        library.cache._mend("")
    assert (tmp_path / "mine").exists()
