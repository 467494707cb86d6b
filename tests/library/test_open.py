"""Files that are no library, or may not be used, are refused with a remedy and left alone."""

import os
import sqlite3
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from sample_library import add_sample, fill, sample_score, sql
from strategies import assert_same_score

from lanindex.errors import LibraryBusyError, LibraryError, LibraryVersionError
from lanindex.library import connect
from lanindex.library.migrate import check, status, upgrade
from lanindex.library.store import Store

pytestmark = pytest.mark.sqlite  # a library in a file


def everything(folder: Path) -> dict[str, bytes]:
    """Return all files below a folder with their content."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def other_program(path):
    with sql(path) as connection:
        connection.execute("CREATE TABLE alembic_version (version_num TEXT)")
        connection.execute("INSERT INTO alembic_version VALUES ('0001')")
        connection.execute("CREATE TABLE photo (name TEXT)")


def half_stamped(path):
    fill(path, 1)
    with sql(path) as connection:
        connection.execute("DELETE FROM alembic_version")


def truncated(path):
    fill(path, 20)
    os.truncate(path, path.stat().st_size // 2)


def cut_in_the_header(path):
    fill(path, 1)
    os.truncate(path, 60)


NO_LIBRARY = {
    "text": (lambda path: path.write_text("walk.bvh;walk\n" * 100), "this is not a library"),
    "folder": (lambda path: path.mkdir(), "this is a folder, wanted a file"),
    "header": (cut_in_the_header, "the library is damaged"),
    "other": (other_program, "another program's database, wanted a library"),
    "stamp": (half_stamped, "another program's database, wanted a library"),
}


@pytest.mark.parametrize("kind", NO_LIBRARY)
@pytest.mark.parametrize("create", [True, False])
def test_no_library_is_refused_and_left_alone(tmp_path, kind, create):
    path = tmp_path / "some.db"
    make, said = NO_LIBRARY[kind]
    make(path)
    before = everything(tmp_path)
    calls = [lambda: Store.open(path, create=create), lambda: status(path), lambda: check(path)]
    for call in [*calls, lambda: upgrade(path)]:
        with pytest.raises(LibraryError, match=said) as caught:
            call()
        assert caught.value.place == str(path)
        assert caught.value.remedy
    assert everything(tmp_path) == before


def test_a_truncated_library_is_called_damaged(tmp_path):
    path = tmp_path / "some.db"
    truncated(path)
    before = everything(tmp_path)
    for call in (lambda: Store.open(path, create=True), lambda: check(path)):
        with pytest.raises(LibraryError, match="the library is damaged"):
            call()
    assert everything(tmp_path) == before


def test_no_library_at_all(tmp_path):
    with pytest.raises(LibraryError, match=r"there is no library here.*lanindex ingest FOLDER"):
        Store.open(tmp_path / "some.db")
    with pytest.raises(LibraryError, match=r"there is no folder .*missing\. Make it first"):
        Store.open(tmp_path / "missing" / "some.db", create=True)
    assert everything(tmp_path) == {}


def test_an_empty_file_is_a_library_to_be(tmp_path):
    path = tmp_path / "some.db"
    path.touch()
    with pytest.raises(LibraryError, match="this file is empty, wanted a library"):
        Store.open(path)
    assert path.read_bytes() == b""
    with Store.open(path, create=True) as library:
        assert library.captures() == []


def test_an_older_library_names_the_upgrade(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    with sql(path) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '0000'")
    before = path.read_bytes()
    with pytest.raises(LibraryVersionError, match="lanindex db upgrade") as caught:
        Store.open(path, create=True)
    assert str(path) in caught.value.remedy
    assert path.read_bytes() == before


def test_a_read_only_file(folder, common_user):
    path = folder / "some.db"
    fill(path, 2)
    path.chmod(0o444)
    before = everything(folder)
    with common_user(), Store.open(path, create=True) as library:
        assert_same_score(library.score(2), sample_score(1))
        with pytest.raises(LibraryError, match=r"may not be written.*--db") as caught:
            add_sample(library, 3)
        assert caught.value.place == str(path)
    assert everything(folder) == before


def test_a_read_only_folder(folder, common_user):
    path = folder / "some.db"
    fill(path, 2)
    path.chmod(0o666)
    folder.chmod(0o555)
    before = everything(folder)
    with common_user():
        with Store.open(path, readonly=True) as library:
            assert_same_score(library.score(2), sample_score(1))
        refused = pytest.raises(LibraryError, match="the library or its folder may not be written")
        with Store.open(path) as library, refused:
            add_sample(library, 3)
        with pytest.raises(LibraryError, match="the library cannot be opened"):
            Store.open(folder / "new.db", create=True)
    assert everything(folder) == before


def test_a_file_that_may_not_be_read(folder, common_user):
    path = folder / "some.db"
    fill(path, 1)
    path.chmod(0)
    with common_user(), pytest.raises(LibraryError, match="the library cannot be opened"):
        Store.open(path)


def test_opened_to_read_it_refuses_to_write(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    before = everything(tmp_path)
    with Store.open(path, readonly=True) as library:
        with pytest.raises(LibraryError, match="may not be written"):
            add_sample(library, 3)
        assert len(library.captures()) == 1
    assert everything(tmp_path) == before


def test_after_closing_there_is_one_file(tmp_path):
    path = tmp_path / "some.db"
    with Store.open(path, create=True) as library:
        add_sample(library, 1)
        add_sample(library, 2)
    assert list(everything(tmp_path)) == ["some.db"]


def test_a_log_that_its_owner_chose_stays(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    with sql(path) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
    with Store.open(path) as library:
        add_sample(library, 1)
    with sql(path) as connection:
        assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        assert connection.execute("SELECT count(*) FROM capture").fetchone() == (2,)


HOLD = """
import sqlite3, sys
connection = sqlite3.connect(sys.argv[1], isolation_level=None)
connection.execute(sys.argv[2])
print("held", flush=True)
sys.stdin.readline()
"""


@contextmanager
def held(path, how):
    """Let another process hold the library."""
    command = [sys.executable, "-c", HOLD, str(path), how]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "held\n"
        yield
        process.communicate("go\n")


def test_a_library_that_is_locked_for_good(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    with held(path, "BEGIN EXCLUSIVE"):
        for create in (True, False):
            with pytest.raises(LibraryBusyError, match=r"another process holds.*Wait") as caught:
                Store.open(path, create=create, timeout=0.1)
            assert caught.value.place == str(path)
    with Store.open(path) as library:
        assert len(library.captures()) == 1


def test_a_library_that_another_writes_can_be_read(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    with held(path, "BEGIN IMMEDIATE"), Store.open(path, timeout=0.1) as library:
        assert_same_score(library.score(1), sample_score(0))
        with pytest.raises(LibraryBusyError):
            add_sample(library, 2)
        assert len(library.captures()) == 1


def test_another_reader_that_does_not_end(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 1)
    reader = sqlite3.connect(path)
    rows = reader.execute("SELECT * FROM symbol")
    rows.fetchone()
    with Store.open(path, timeout=0.1) as library:
        with pytest.raises(LibraryBusyError):
            add_sample(library, 2)
        assert len(library.captures()) == 1
        rows.close()
        add_sample(library, 2)
        assert len(library.captures()) == 2
    reader.close()


def test_any_name_of_a_file(tmp_path):
    for name in ("so me.db", "a?mode=ro", "50%20#.db", "ä.db", "no-suffix"):
        fill(tmp_path / name, 1)
        with Store.open(str(tmp_path / name)) as library:
            assert len(library.captures()) == 1
    assert len(everything(tmp_path)) == 5


def test_a_url(tmp_path):
    fill(tmp_path / "some.db", 2)
    with Store.open(f"sqlite:///{tmp_path / 'some.db'}") as library:
        assert len(library.captures()) == 2


@pytest.mark.parametrize("url", ["nonsense://x", "://", "postgresql+nothing://me:secret@host/db"])
def test_a_url_of_nothing(url):
    with pytest.raises(LibraryError) as caught:
        Store.open(url)
    assert "secret" not in str(caught.value)


def test_the_mode_of_a_new_file_is_the_users(tmp_path):
    path = tmp_path / "some.db"
    before = os.umask(0o027)
    try:
        Store.open(path, create=True).close()
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_library_to_be_read_is_not_written(tmp_path):
    fill(tmp_path / "some.db", 1)
    with Store.open(tmp_path / "some.db", readonly=True) as library:
        with pytest.raises(LibraryError, match="may not be written"):
            library.remove(1)
        assert len(library.captures()) == 1


@pytest.mark.sqlite
@pytest.mark.parametrize(
    ("url", "login", "shown"),
    [
        ("postgres://host", {"host": "host"}, "postgres://host"),
        (
            "postgresql+psycopg://ada:a%40b/c#@host:5433/lan?sslmode=require",
            {"user": "ada", "password": "a@b/c#", "host": "host", "port": "5433", "dbname": "lan"}
            | {"sslmode": "require"},
            "postgresql+psycopg://ada:***@host:5433/lan?sslmode=require",
        ),
        (
            "postgresql:///lan?host=/tmp&options=-csearch_path=a%2Cb&password=x&user=ada",
            {"dbname": "lan", "host": "/tmp", "options": "-csearch_path=a,b"}
            | {"password": "x", "user": "ada"},
            "postgresql:///lan?host=/tmp&options=-csearch_path=a%2Cb&password=***&user=ada",
        ),
        (
            "postgres://host/lan?sslpassword=x",
            {"host": "host", "dbname": "lan", "sslpassword": "x"},
            "postgres://host/lan?sslpassword=***",
        ),
        ("postgresql://@[::1]:1/", {"host": "::1", "port": "1"}, "postgresql://@[::1]:1/"),
    ],
)
def test_the_address_of_a_server_is_understood_and_shown_without_its_password(url, login, shown):
    where = connect.target(url)
    assert (where.login, where.place) == (login, shown)
