"""What PostgreSQL promises beside what all libraries do: one state, waiting, rights, damage."""

import os
import socket
import subprocess
import sys
from contextlib import closing
from threading import Event, Thread

import command
import psycopg
import pytest
from crowd import crowd
from in_shards import Here
from postgres_server import serving
from sample_library import add_sample, fill, name_of, sample_score
from strategies import assert_same_score

from lanindex.errors import AbsentError, LibraryBusyError, LibraryError
from lanindex.library import cache, connect
from lanindex.library.migrate import check, keep_columns, status, upgrade
from lanindex.library.store import Store
from lanindex.pipeline import shards
from lanindex.pipeline.library import open_library


@pytest.fixture
def url(tmp_path, database):
    if database == "sqlite":
        pytest.skip("about a server")
    return name_of(tmp_path / "some.db")


def test_a_reader_sees_one_state_and_keeps_nobody_waiting(url):
    fill(url, 2)
    with Store.open(url, readonly=True) as reader, Store.open(url) as writer:
        with reader.session.reading() as link:
            count = "SELECT count(*) FROM capture"
            before = connect.ask(link, count).fetchone()
            add_sample(writer, 7)
            assert connect.ask(link, count).fetchone() == before == (2,)
            asked = "SHOW transaction_isolation", "SHOW transaction_read_only"
            assert [link.execute(it).fetchone()[0] for it in asked] == ["repeatable read", "on"]
        assert len(reader.captures()) == 3


def test_a_library_that_is_only_read_is_not_written(url):
    fill(url, 2)
    with Store.open(url, readonly=True) as store:
        with pytest.raises(LibraryError, match="may only be read here"):
            store.remove(1)
        assert len(store.captures()) == 2


def test_a_writer_waits_for_another_one_but_not_for_ever(url):
    fill(url, 1)
    held, go_on = Event(), Event()

    def hold():
        with Store.open(url) as store, store.session.writing():
            held.set()
            go_on.wait(60)

    holder = Thread(target=hold)
    holder.start()
    assert held.wait(60)
    with Store.open(url, timeout=0.2) as store:
        with pytest.raises(LibraryBusyError, match="another process writes"):
            add_sample(store, 7)
        assert len(store.captures()) == 1
    with Store.open(url) as store:
        waiting = Thread(target=add_sample, args=(store, 8))
        waiting.start()
        go_on.set()
        waiting.join(60)
        holder.join(60)
        assert len(store.captures()) == 2


def test_two_make_the_tables_at_once(url):
    command = [sys.executable, "-c", MAKE, url]
    made = [subprocess.Popen(command) for _ in range(3)]
    assert [one.wait(60) for one in made] == [0, 0, 0]
    assert check(url) == []


MAKE = """
import sys
from lanindex.library.store import Store
from lanindex.pipeline import shards
from lanindex.pipeline.library import open_library
Store.open(sys.argv[1], create=True).close()
"""


def test_connections_that_the_server_cut_are_made_anew(url):
    fill(url, 2)
    with Store.open(url) as store:
        cut(store)  # while nothing is asked
        assert len(store.captures()) == 2
        with pytest.raises(LibraryError, match="the server broke it off"):
            change_and_cut(store)
        add_sample(store, 7)
        assert len(store.captures()) == 3
    assert check(url) == []


def change_and_cut(store):
    with store.changing() as link:
        connect.ask(link, "DELETE FROM capture")
        cut(store)
        connect.ask(link, "DELETE FROM segment_pending")


def cut(store):
    """Have the server end all connections of a library but the one that asks."""
    link = connect.connected(store.session.target, create=False, readonly=False, timeout=5)
    with closing(link):
        link.execute(
            "SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity "
            "WHERE application_name = 'lanindex' AND pid <> pg_backend_pid()"
        )


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [
        ("owner@", "nobody@", r"refuses this user \(role \"nobody\" .*Check user and password"),
        ("/postgres?", "/none?", r"database \"none\" does not exist\. .*createdb"),
        ("host=", "port=1&host=", r"server cannot be reached: .*Check the address"),
        ("host=", "nothing=1&host=", r"server cannot be reached: invalid connection option"),
        ("search_path%3Dl", "search_path%3Dm", r"no such schema .*CREATE SCHEMA"),
    ],
)
def test_an_address_that_is_wrong(url, right, wrong, says):
    with pytest.raises(LibraryError, match=says):
        Store.open(url.replace(right, wrong), create=True)


@pytest.mark.parametrize("encoding", ["SQL_ASCII", "LATIN1"])
def test_a_database_that_is_not_in_utf8_keeps_what_it_can(url, server, encoding):
    with server.connect(autocommit=True) as link:
        link.execute(f"CREATE DATABASE other ENCODING '{encoding}' TEMPLATE template0")
    other = f"{url.partition('/postgres?')[0]}/other?host={server.folder}"
    try:
        with Store.open(other, create=True) as store:
            add_sample(store, 1)
            store.label(1, "é")
            assert store.capture(1).label == "é"
            if encoding == "LATIN1":
                with pytest.raises(LibraryError, match="cannot keep this: character"):
                    store.label(1, "盆踊り")
                assert store.capture(1).label == "é"
    finally:
        with server.connect(autocommit=True) as link:
            link.execute("DROP DATABASE other WITH (FORCE)")


@pytest.mark.slow
def test_a_server_that_crashes_loses_nothing(tmp_path, database):
    if database == "sqlite":
        pytest.skip("about a server")
    with serving("") as server:
        with server.connect(autocommit=True) as link:
            link.execute("CREATE SCHEMA one")
        url = server.url("one")
        fill(url, 3)
        with Store.open(url) as store:
            server.stop("immediate")
            with pytest.raises(LibraryError, match=r"(broke it off|cannot be reached)"):
                add_sample(store, 7)
            with pytest.raises(LibraryError, match=r"cannot be reached.*runs"):
                store.captures()
            server.start()
            assert len(store.captures()) == 3
            add_sample(store, 7)
        assert check(url) == []


def test_damaged_columns_are_made_anew(url):
    fill(url, 3)
    with Store.open(url) as store:
        store.cache.compact()
        with store.session.writing() as link:
            connect.ask(link, "UPDATE segment_column SET content = '\\x00' WHERE name = 'cell'")
    with Store.open(url, readonly=True) as store:
        roster, columns = store.columns(["head"])
        assert len(roster) == 3
        assert len(columns["head"]) == 18
        assert len(store.session.notes) == 1
    assert check(url) == []


def test_damaged_rows_are_named(url):
    fill(url, 2)
    with Store.open(url) as store, store.session.writing() as link:
        connect.ask(link, "UPDATE symbol_code SET sign = sign + 1 WHERE capture_id = 2")
    (line,) = [it for it in check(url) if "capture 2" in it]
    assert "is damaged in the library: its track" in line
    with Store.open(url, readonly=True) as store, pytest.raises(LibraryError, match="capture 2"):
        store.score(2)


def test_a_view_of_another_version_is_made_anew(url):
    fill(url, 1)
    with Store.open(url) as store, store.session.writing() as link:
        link.execute("DROP VIEW symbol")
        link.execute("CREATE VIEW symbol AS SELECT 1 AS one")
    assert "the view symbol" in check(url)[0]
    assert upgrade(url).state == "current"
    assert check(url) == []


def test_columns_in_files_stay_while_a_reader_may_need_them(url, tmp_path):
    fill(url, 3)
    keep_columns(url, str(tmp_path / "files"))
    files = set(tmp_path.glob("files/*"))
    assert len(files) == 1
    with Store.open(url, readonly=True) as reader, Store.open(url) as store:
        with reader.session.reading() as link:
            connect.ask(link, "SELECT file FROM segment")  # its state is that of the first question
            fill(url, 9)  # a larger segment takes the place of the first
            store.cache.compact()
            store.cache.compact()
            now = set(tmp_path.glob("files/*"))
            assert now > files
        fill(url, 19)
        store.cache.compact()
        assert not files & set(tmp_path.glob("files/*"))
        assert len(reader.columns(["head"])[1]["head"]) == 19 * 6
    assert check(url) == []


ROLES = """CREATE ROLE ada LOGIN IN ROLE lanindex_reader;
CREATE ROLE ben LOGIN IN ROLE lanindex_writer;"""


def test_readers_and_writers_may_do_what_the_guide_says(url, server, repository, monkeypatch):
    monkeypatch.setattr(cache, "MOST_PENDING", 2)
    fill(url, 5)
    page = (repository / "lanindex" / "guide" / "growing.md").read_text()
    schema = url.rpartition("%3D")[2]
    roles = page.partition("```sql\n")[2].partition("```")[0] + ROLES
    with server.connect(autocommit=True) as link:
        link.execute(roles.replace("SCHEMA public", f"SCHEMA {schema}"))
    reader, writer = url.replace("owner@", "ada@"), url.replace("owner@", "ben@")
    try:
        with Store.open(writer, create=True) as store:
            add_sample(store, 5)
            store.label(1, "walk")
            store.remove(2)
            store.cache.compact()
        with Store.open(reader) as store:
            assert store.capture(1).label == "walk"
            assert len(store.columns(["head"])[0]) == 5
            assert store.session.notes == []
            with pytest.raises(LibraryError, match=r"no right to do this.*role of a reader or"):
                store.label(1, "run")
        with (
            open_library(reader) as library,
            pytest.raises(LibraryError, match=r"no right to do this.*role of a reader or"),
        ):
            library.ingest("nowhere.bvh")  # before it is found to be missing
        words = "ingest", repository / "corpus", "--db", reader, "--cluster", "tcp://127.0.0.1:1"
        assert "no right to do this" in command.run(*words).stderr  # before that is reached
        with open_library(writer) as library:
            before = library.stamp
            assert [it.status for it in library.ingest("nowhere.bvh")] == ["failed"]
            assert library.stamp == before
            assert library.ingest(repository / "corpus" / "greetings.bvh")[0].status == "added"
        with open_library(reader) as library:  # nothing is new to it
            (outcome,) = library.ingest(repository / "corpus" / "greetings.bvh")
            assert outcome.status == "unchanged"
        fill(url, 5)
        with open_library(reader) as library:  # all have changed, and no segment has them
            assert len(library.search("head any")) > 0
            assert "columns cannot be written (you have no right" in library.notes[-1]
        for may_not in (reader, writer):
            with pytest.raises(LibraryError, match="no right"):
                drop_view(may_not)
        assert check(reader) == []
    finally:
        with server.connect(autocommit=True) as link:
            link.execute("DROP OWNED BY lanindex_reader, lanindex_writer")
            link.execute("DROP ROLE ada, ben, lanindex_reader, lanindex_writer")


def drop_view(url):
    with Store.open(url) as store, store.session.writing() as link:
        link.execute("DROP VIEW symbol")


class Later(Here):
    """Other processes that begin once the library has changed."""

    def results(self, work, items, tick):
        fill(self.url, 12)
        with Store.open(self.url) as store:
            store.cache.compact()
        yield from super().results(work, items, tick)


def test_a_search_in_other_processes_ends_on_the_state_that_it_began_with(url, monkeypatch):
    monkeypatch.setattr(shards, "FEWEST", 1)
    fill(url, 3)
    with Store.open(url) as store:
        store.cache.compact()
    with open_library(url, readonly=True) as library:
        before = library.search("head any").dicts()
        assert len({hit["capture_id"] for hit in before}) == 3
        library.spread = Later(2)
        library.spread.url = url
        assert len(library.search("head any")) == len(before)
        library.spread = Here(2)
        assert len({hit.capture.id for hit in library.search("head any")}) == 12


@pytest.mark.slow
def test_a_server_that_does_not_answer():
    with socket.create_server(("127.0.0.1", 0)) as silent:
        place = f"postgresql://me@127.0.0.1:{silent.getsockname()[1]}/x?connect_timeout=2"
        with pytest.raises(LibraryError, match=r"cannot be reached: .*Check the address in --db"):
            Store.open(place)


def test_no_server_and_no_database(url):
    for place, said in (
        (
            "postgresql://me:secret@/x?host=/nowhere",
            r"me:\*\*\*@.*cannot be reached: .*No such file",
        ),
        (url.replace("/postgres?", "/nothing?"), r'database "nothing" does not exist'),
        (url.replace("owner@", "nobody@"), r'role "nobody" does not exist'),
        ("mysql://host/x", r"names no kind of library, wanted a path, or postgresql"),
    ):
        with pytest.raises(LibraryError, match=said) as caught:
            Store.open(place)
        assert "secret" not in str(caught.value)


def test_a_database_without_a_library(url):
    with pytest.raises(LibraryError, match=r"there is no library in this database.*ingest"):
        Store.open(url)
    with pytest.raises(AbsentError):
        status(url)


def test_text_that_the_server_cannot_hold(url):
    with Store.open(url, create=True) as store:
        with pytest.raises(LibraryError, match=r"NUL"):
            add_sample(store, 1, label="a\0b")
        assert store.captures() == []
        assert os.path.basename(add_and_read(store, "Ä\U0001f483")) == "Ä\U0001f483"


def add_and_read(store, label):
    return store.capture(add_sample(store, 2, label=label)).label


def test_the_bytes_of_a_library(url):
    fill(url, 3)
    with Store.open(url) as store:
        assert store.stats().size > 50_000
    with psycopg.connect(connect.target(url).url.replace("+psycopg", "")) as link:
        asked = "SELECT part, direction FROM symbol WHERE part = 'head' LIMIT 1"
        assert link.execute(asked).fetchone() == ("head", "right")


@pytest.mark.slow
def test_two_write_and_fifty_read(url, server):
    fill(url, 0)
    schema = url.rpartition("%3D")[2]
    with server.connect(autocommit=True) as link:
        link.execute("CREATE ROLE reader LOGIN")
        link.execute(f"GRANT USAGE ON SCHEMA {schema} TO reader")
        link.execute(f"GRANT SELECT ON ALL TABLES IN SCHEMA {schema} TO reader")
    try:
        reader = url.replace("owner@", "reader@")
        wrote, _, waiting = crowd(server, url, reader, writers=2, readers=50, each=50)
    finally:
        with server.connect(autocommit=True) as link:
            link.execute("DROP OWNED BY reader")
            link.execute("DROP ROLE reader")
    assert waiting == {"owner"}  # the writers, for each other
    longest = max(max(one["took"]) for one in wrote)
    assert max(max(one["waited"]) for one in wrote) < longest + 0.5
    with Store.open(url) as store:
        assert len(store.captures()) == 100
        for number in range(100):
            assert_same_score(store.score(f"{number}.bvh"), sample_score(number))
    assert check(url) == []


def test_a_library_that_is_taken_away_meanwhile(url):
    fill(url, 1)
    with Store.open(url) as store:
        with store.session.writing() as link:
            link.execute("DROP TABLE state")
        with pytest.raises(LibraryError, match=r"no longer there.*state.*Name another"):
            store.captures()
