"""`db check` finds and names every kind of damage."""

from fractions import Fraction

import pytest
from sample_library import add_sample, fill, sample_score, sql

from lanindex.library import rows
from lanindex.library.migrate import check, upgrade
from lanindex.library.store import Store
from lanindex.model import Meter, Score, Track


def damage(number: int, what: str) -> str:
    place = f"FOLDER/{number - 1}.bvh"
    return (
        f"{place}: capture {number} is damaged in the library: {what}, wanted what was stored. "
        f"Write it down anew: lanindex ingest --force {place}"
    )


def lost(found: int) -> str:
    return f"the library holds {found} captures whose numbers add up to 2, wanted 2 and 3, as were"


FILE, LIST = "what is known of its file", "the list of its tracks"
SAID = "its label or metadata (say them again, too)"
HEADING = "its heading or the lines that were not understood"

WRONG = {
    "UPDATE symbol_code SET start = start + 7 WHERE track = 2 AND ordinal = 2 AND capture_id = 1": (
        damage(1, "its track head")
    ),
    "UPDATE symbol_code SET sign = 'x' WHERE track = 2 AND ordinal = 2 AND capture_id = 2": (
        damage(2, "its track number 2 holds what is no number")
    ),
    "DELETE FROM symbol_code WHERE track = 2 AND ordinal = 3 AND capture_id = 2": (
        damage(2, "its track head")
    ),
    "DELETE FROM symbol_code WHERE track = 2 AND capture_id = 2": damage(2, "its track head"),
    "INSERT INTO symbol_code VALUES (1, 2, 6, 1, 1, 1, 1, 1, 1)": damage(1, "its track head"),
    "DELETE FROM track WHERE capture_id = 2 AND part = 'head'": damage(2, LIST),
    "DELETE FROM track WHERE capture_id = 2 AND part = 'l_arm'": (
        "a row of symbol_code hangs on a row of track that does not exist"
    ),
    "UPDATE track SET known = '[[0' WHERE capture_id = 2 AND part = 'head'": damage(2, LIST),
    "UPDATE track SET part = 'r_leg' WHERE capture_id = 2 AND part = 'head'": damage(2, LIST),
    "UPDATE track SET kind = 1 WHERE capture_id = 2 AND part = 'head'": damage(2, LIST),
    "DELETE FROM capture WHERE id = 1": lost(1),
    "DELETE FROM state": "the library's state is [], wanted one row of whole numbers.",
    "UPDATE state SET captures = 3": "captures whose numbers add up to 3, wanted 3 and 3, as were",
    "UPDATE state SET numbers = 9": "captures whose numbers add up to 3, wanted 2 and 9, as were",
    "UPDATE state SET stamp = x'ff'": "wanted one row of whole numbers.",
    "INSERT INTO profile VALUES (7, 'spare', 'x')": "the profile spare wrote nothing down",
    "UPDATE profile SET name = 'other'": damage(1, FILE),
    "UPDATE capture SET speed = x'ff' WHERE id = 1": damage(1, FILE),
    "UPDATE capture SET frames = 'z' WHERE id = 1": damage(1, FILE),
    "UPDATE capture SET rate = '30/0' WHERE id = 1": damage(1, FILE),
    "UPDATE capture SET options = '{' WHERE id = 2": damage(2, FILE),
    "UPDATE capture SET warnings = '[\"x\"]' WHERE id = 2": damage(2, FILE),
    "UPDATE capture SET other = '[]' WHERE id = 2": damage(2, HEADING),
    "UPDATE capture SET heading = 'text' WHERE id = 2": damage(2, HEADING),
    "UPDATE capture SET label = 'x' WHERE id = 2": damage(2, SAID),
    "INSERT INTO metadata VALUES (2, 'who', 'x')": damage(2, SAID),
    "UPDATE capture SET path = CAST(x'2fff' AS TEXT) WHERE id = 2": damage(2, FILE),
    "UPDATE state SET columns = 7": (
        "the columns are out of date, for another program has changed the library. They are made "
        "anew by: lanindex db upgrade"
    ),
    "UPDATE segment_column SET content = x'00' WHERE part = 'head' AND name = 'cell'": (
        "the columns are damaged: cell of head in segment 1. They are made anew by"
    ),
    "DELETE FROM segment_pending": "the columns are damaged: they are not those of the captures",
    "DROP VIEW symbol": "the view symbol does not show what the library holds",
}


def test_nothing_is_wrong_with_a_new_library(tmp_path):
    fill(tmp_path / "some.db", 3)
    assert check(tmp_path / "some.db") == []


@pytest.mark.parametrize("change", ["DROP VIEW symbol", "CREATE VIEW symbol AS SELECT 1"])
def test_a_view_of_an_earlier_version_is_made_anew(tmp_path, change):
    place = tmp_path / "some.db"
    fill(place, 1)
    with sql(place) as connection:
        connection.execute("DROP VIEW symbol")
        if change != "DROP VIEW symbol":
            connection.execute(change)
    (found,) = check(place)
    assert found.endswith("It is made anew by: lanindex db upgrade")
    upgrade(place)
    assert check(place) == []
    with sql(place) as connection:
        kinds = {kind for (kind,) in connection.execute("SELECT kind FROM symbol")}
    assert kinds == {"gesture"}


@pytest.mark.sqlite
@pytest.mark.parametrize("change", WRONG)
def test_what_is_wrong_is_named(tmp_path, change, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fill(tmp_path / "some.db", 1)
    with Store.open("some.db") as library:
        library.cache.compact()
        add_sample(library, 1)
    with sql(tmp_path / "some.db") as connection:
        connection.execute(change)
    wanted = WRONG[change].replace("FOLDER", str(tmp_path))
    assert [line for line in check(tmp_path / "some.db") if wanted in line]


def test_columns_that_no_search_reads_are_made_anew(tmp_path):
    place = tmp_path / "some.db"
    fill(place, 3)
    with Store.open(place) as library:
        library.cache.compact()
    with sql(place) as connection:
        connection.execute("DELETE FROM segment_column WHERE part = 'head'")
    assert check(place) != []
    upgrade(place)
    assert check(place) == []


@pytest.mark.sqlite
def test_columns_of_other_symbols_are_found(tmp_path):
    path = tmp_path / "some.db"
    for number in (0, 1):  # the second time with other rows, and the columns of the first
        with Store.open(tmp_path / f"{number}.db", create=True) as library:
            for place in range(3):
                score = sample_score(number * (place == 1))
                library.add(f"{place}.bvh", score, format="bvh", sha256="0")
            library.cache.compact()
    (tmp_path / "1.db").rename(path)
    with sql(path) as connection:
        connection.execute("ATTACH ? AS other", (str(tmp_path / "0.db"),))
        for table in ("segment", "segment_column"):
            connection.execute(f"DELETE FROM {table}")
            connection.execute(f"INSERT INTO {table} SELECT * FROM other.{table}")
    (found,) = check(path)
    assert found == (
        "the columns of captures 1 to 3 in segment 1 are not those of their rows, wanted the "
        "same. Have them made anew: UPDATE state SET columns = -1"
    )
    with sql(path) as connection:
        connection.execute("UPDATE state SET columns = -1")
    with Store.open(path) as library:
        library.cache.compact()
    assert check(path) == []


def test_many_of_a_kind_are_cut_short(tmp_path):
    fill(tmp_path / "some.db", 9)
    with sql(tmp_path / "some.db") as connection:
        connection.execute("UPDATE symbol_code SET start = start + 1")
    found = check(tmp_path / "some.db")
    assert len(found) == 6
    assert found[-1] == "… and 4 more like it"


@pytest.mark.sqlite
def test_nonsense_that_a_program_stored_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(rows, "check", lambda *_: None)
    symbols = sample_score().tracks["head"].symbols.copy()
    symbols["stop"][2] = 900
    score = Score(Fraction(30), 60, Meter(), {"head": Track("head", symbols, ())})
    with Store.open(tmp_path / "some.db", create=True) as library:
        library.add("a.bvh", score, format="bvh", sha256="0")
    monkeypatch.undo()
    (found,) = check(tmp_path / "some.db")
    assert found.startswith("a.bvh: head, symbol 2 is (")


@pytest.mark.sqlite
@pytest.mark.parametrize("frame", [0xD800, 0xFFFD, 1 << 20])
def test_no_number_is_taken_for_another(tmp_path, frame):
    symbols = sample_score().tracks["head"].symbols[:1].copy()
    for name in ("start", "stop", "tick", "ticks"):
        symbols[name] = frame
    score = Score(Fraction(30), frame, Meter(), {"head": Track("head", symbols, ())})
    with Store.open(tmp_path / "some.db", create=True) as library:
        library.add("a.bvh", score, format="bvh", sha256="0")
        assert library.score(1).tracks["head"].symbols.tolist() == symbols.tolist()
    for column in ("start", "tick", "ticks", "sign", "notes"):
        for wild in ("-1", "0x110000", "0xFFFD0000000000"):
            change = f"UPDATE symbol_code SET {column} = "
            with sql(tmp_path / "some.db") as connection:
                ((stored,),) = connection.execute(f"SELECT {column} FROM symbol_code")
                connection.execute(change + wild)
            if stored != int(wild, 0):
                assert damage(1, "its track head").split(": ")[1] in check(tmp_path / "some.db")[0]
            with sql(tmp_path / "some.db") as connection:
                connection.execute(f"{change}{stored}")
    assert check(tmp_path / "some.db") == []


@pytest.mark.sqlite
def test_a_damaged_page_is_found(tmp_path):
    path = tmp_path / "some.db"
    fill(path, 40)
    content = bytearray(path.read_bytes())
    content[-4096:] = bytes(range(256)) * 16
    path.write_bytes(content)
    (found,) = check(path)[:1]
    assert found.startswith("the file is damaged: ")


@pytest.mark.sqlite
def test_a_look_at_the_pages_is_told_and_can_be_broken_off(tmp_path):
    path, told = tmp_path / "some.db", []
    fill(path, 40)

    def progress(noun, done, total):
        told.append((noun, done, total))
        if len(told) == last:
            raise KeyboardInterrupt

    last = 1
    with pytest.raises(KeyboardInterrupt):
        check(path, progress)
    last = -1
    assert check(path, progress) == []
    assert {noun for noun, *_ in told} == {"pages", "captures"}
    pages = [(done, total) for noun, done, total in told if noun == "pages"]
    assert pages[-1] == (path.stat().st_size // 4096,) * 2
