"""Every revision leads to the tables of schema.py, and takes the rows along."""

import importlib
import shutil

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sample_library import fill, sample_score, sql
from strategies import assert_same_score

from lanindex.errors import LibraryError, LibraryVersionError
from lanindex.library import migrate, schema
from lanindex.library.connect import REVISION, altering, connected, target, transaction
from lanindex.library.store import Store

pytestmark = pytest.mark.sqlite  # a library in a file


def revisions() -> list[str]:
    script = ScriptDirectory(str(migrate.scripts()))
    return [one.revision for one in reversed(list(script.walk_revisions()))]


def made_at(path, revision):
    """Return a connection to a new library at a revision."""
    link = connected(target(path), create=True, readonly=False, timeout=1)
    with altering(link) as connection:
        migrate.run(connection, revision, str(path))
    return link


def tables(path) -> dict[str, list[str]]:
    """Return the lines of each table's SQL; their order does not matter."""
    with sql(path) as connection:
        found = connection.execute("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL")
        return {
            name: sorted(line.strip(" ,\t") for line in sql.splitlines()) for name, sql in found
        }


def test_the_newest_revision_is_the_schemas():
    script = ScriptDirectory(str(migrate.scripts()))
    assert script.get_heads() == [REVISION]
    assert revisions() == sorted(revisions())


@pytest.mark.parametrize("revision", revisions())
def test_every_revision_leads_to_the_schema(tmp_path, revision):
    path = tmp_path / "old.db"
    made_at(path, revision).close()
    assert migrate.status(path).revision == revision
    assert migrate.upgrade(path).state == "current"
    link = connected(target(path), create=False, readonly=False, timeout=1)
    with altering(link) as connection:
        assert compare_metadata(MigrationContext.configure(connection), schema.tables) == []
    link.close()
    assert migrate.status(path).state == "current"


@pytest.mark.parametrize("revision", revisions())
def test_every_revision_keeps_the_rows(tmp_path, revision):
    path = tmp_path / "old.db"
    connection = made_at(path, revision)
    rows = ROWS[revision]
    with transaction(connection, writes=True):
        for statement in rows:
            connection.execute(statement)
    connection.close()
    migrate.upgrade(path)
    with Store.open(path) as library:
        (capture,) = library.captures()
        assert (capture.path, capture.label, capture.metadata) == ("a.bvh", "walk", {"who": "x"})
        (symbol,) = library.score(1).symbols("r_arm")
        assert str(symbol) == "r_arm right mid [2, 5)"
        _, columns = library.columns(["r_arm"])
        assert (columns["r_arm"].start.tolist(), library.session.notes) == ([2], [])
    assert migrate.check(path) == []


ROWS = {
    "0001": [
        "INSERT INTO profile VALUES (1, 'default', 'aa')",
        "INSERT INTO capture VALUES (1, 'a.bvh', '/a.bvh', 'bvh', 'ff', 'walk', 30, '30', 9, '60',"
        " 4, 4, 32, 1, '{}', '[]', x'')",
        "INSERT INTO metadata VALUES (1, 'who', 'x')",
        "INSERT INTO track VALUES (1, 'r_arm', 0, '[[0, 9]]')",
        "INSERT INTO symbol VALUES (1, 'r_arm', 0, 'right', 'mid', 2, 5, 2, 3, 0, 0, 0, 0.5,"
        " 'right', 'high')",
    ],
    "0002": [
        "UPDATE state SET stamp = 3, captures = 1, numbers = 1",
        "INSERT INTO profile VALUES (1, 'default', 'aa')",
        "INSERT INTO capture VALUES (1, 'a.bvh', '/a.bvh', 'bvh', 'ff', 'walk', 30, '30', 9, '60',"
        " 4, 4, 32, 1, '{}', '[]', -189751464, -1594958232, 1753983228, 1297901499, '[]',"
        " x'01789c030000000001')",
        "INSERT INTO metadata VALUES (1, 'who', 'x')",
        "INSERT INTO track VALUES (1, 0, 'r_arm', 0, NULL, 1, -380827888)",
        "INSERT INTO symbol_code VALUES (1, 0, 0, 4099169, 2, 3, 2, 3, 0)",
    ],
}
ROWS["0003"] = [
    "UPDATE state SET stamp = 3, captures = 1, numbers = 1, columns = 3",
    "INSERT INTO segment_pending VALUES (1)",
    *ROWS["0002"][1:],
]
ROWS["0005"] = ROWS["0004"] = ROWS["0003"]
"""The same content in the tables of each revision."""


def test_a_new_library_is_what_the_revisions_make(tmp_path):
    made_at(tmp_path / "steps.db", "head").close()
    Store.open(tmp_path / "once.db", create=True).close()
    assert tables(tmp_path / "once.db") == tables(tmp_path / "steps.db")


@pytest.fixture
def next_revision(tmp_path, monkeypatch):
    """Give the program one more revision, which rebuilds two tables."""
    folder = tmp_path / "100% migrations"
    shutil.copytree(migrate.scripts(), folder)
    (folder / "versions" / "0006_note.py").write_text(
        "import sqlalchemy as sa\n"
        "from alembic import op\n"
        "revision, down_revision = '0006', '0005'\n"
        "def upgrade():\n"
        "    for name in ('capture', 'track'):\n"
        "        with op.batch_alter_table(name, recreate='always') as table:\n"
        "            table.add_column(sa.Column('note', sa.Text))\n"
    )
    monkeypatch.setattr(migrate, "_FOLDERS", (folder,))
    for module in (migrate, importlib.import_module("lanindex.library.connect")):
        monkeypatch.setattr(module, "REVISION", "0006")
    return folder


def test_rebuilding_a_table_keeps_what_hangs_on_it(tmp_path, request):
    path = tmp_path / "a.db"
    fill(path, 3)
    request.getfixturevalue("next_revision")
    with pytest.raises(LibraryVersionError, match=r"revision 0005, wanted 0006.*db upgrade"):
        Store.open(path)
    assert migrate.status(path).state == "older"
    assert migrate.upgrade(path).revision == "0006"
    with Store.open(path) as library:
        for number in (1, 2, 3):
            assert_same_score(library.score(number), sample_score(number - 1))
    assert migrate.check(path) == []


def test_an_upgrade_that_fails_changes_nothing(tmp_path, request):
    path = tmp_path / "a.db"
    fill(path, 2)
    before = tables(path)
    folder = request.getfixturevalue("next_revision")
    script = folder / "versions" / "0006_note.py"
    script.write_text(script.read_text() + "    op.execute('DELETE FROM track')\n")
    with pytest.raises(LibraryError, match="rows would hang on nothing"):
        migrate.upgrade(path)
    assert tables(path) == before
    assert migrate.status(path).revision == "0005"


def test_an_upgrade_says_nothing_by_itself(tmp_path, request, capfd, caplog):
    path = tmp_path / "a.db"
    fill(path, 1)
    request.getfixturevalue("next_revision")
    caplog.set_level("WARNING")
    migrate.upgrade(path)
    assert capfd.readouterr() == ("", "")
    assert not caplog.records


def test_the_status_tells_of_the_columns(tmp_path):
    path = tmp_path / "a.db"
    fill(path, 2)
    found = migrate.status(path)
    assert (found.segments, found.symbols, found.pending, found.fault) == (0, 0, 2, "")
    with Store.open(path) as library:
        library.cache.compact()
    found = migrate.status(path)
    assert (found.segments, found.symbols, found.pending, found.fault) == (1, 36, 0, "")
    with sql(path) as connection:
        connection.execute("UPDATE segment SET listing = '[]'")
    assert migrate.status(path).fault == "damaged: the listing of segment 1"


def test_a_revision_unknown_to_all_is_refused(tmp_path):
    path = tmp_path / "a.db"
    fill(path, 1)
    with sql(path) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '0000'")
    with pytest.raises(LibraryError, match="no way leads from its revision"):
        migrate.upgrade(path)


def test_a_newer_library_is_not_touched(tmp_path):
    path = tmp_path / "a.db"
    fill(path, 1)
    with sql(path) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
    before = path.read_bytes()
    assert migrate.status(path).state == "newer"
    for call in (Store.open, migrate.upgrade, migrate.check):
        with pytest.raises(LibraryVersionError, match=r"made by a newer LanIndex.*9999"):
            call(path)
    assert path.read_bytes() == before


def test_an_installation_without_migrations_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(migrate, "_FOLDERS", (tmp_path,))
    with pytest.raises(LibraryError, match="lacks its migrations"):
        migrate.scripts()
