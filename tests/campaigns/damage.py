"""Damage a library in any way: each answer is the right one, or an error that names the damage.

Bits are turned over, pages exchanged, cut off, or those of the same library at another time; rows
and columns are changed behind its back. Then verbs ask the library in any order. A file with pages
of two times may answer as at either time; where it answers as at neither, or one verb so and the
next otherwise, which checksums of rows cannot tell, ``db check`` finds damage.
"""

from __future__ import annotations

import re
import shutil
import sqlite3
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import chdir, closing
from pathlib import Path
from random import Random
from typing import Any

import common
from common import called, errors_of
from damaged_library import change_a_cell, put_a_row_in_twice, take_out_a_row, turn_a_bit

from lanindex.library.store import Store

LIBRARY, JOURNAL = Path("some.db"), Path("some.db-journal")
PAGE = 4096
VERBS = {
    "list": ("list", "--json"),
    "show": ("show", "--all", "--json"),
    "search": ("search", "r_arm low -> mid", "--json"),
    "search with": ("search", "r_arm any with l_arm any", "--json"),
    "search where": ("search", "arm any 0.3s+", "--where", "label=w*", "--in", "*.*", "--json"),
    "stats": ("stats", "--json"),
    "export": ("export", "r_arm low -> mid", "--in", "*.bvh", "-o", "clips", "--json"),
    "count": ("search", "arm high | count by clip.label", "--json"),
}

Files = list[bytes]
"""A library after each of its changes, the last of which is now."""


def some_bytes(now: bytearray, files: Files, choice: Random) -> None:
    """Write nonsense over a few bytes, of one place or of several."""
    for _ in range(choice.choice((1, 1, 2, 9))):
        at, length = choice.randrange(len(now)), choice.choice((1, 2, 8, 100))
        piece = now[at : at + length]
        kind = choice.choice(
            (choice.randbytes(len(piece)), bytes(len(piece)), b"\xff" * len(piece))
        )
        now[at : at + length] = kind


def a_header(now: bytearray, files: Files, choice: Random) -> None:
    """Change bytes where a file or a page of it begins."""
    at = PAGE * choice.choice((0, choice.randrange(len(now) // PAGE)))
    now[at + choice.randrange(100)] = choice.randrange(256)


def page_of(content: bytes | bytearray, choice: Random) -> int:
    return PAGE * choice.randrange(1, len(content) // PAGE)


def exchanged_pages(now: bytearray, files: Files, choice: Random) -> None:
    one, other = page_of(now, choice), page_of(now, choice)
    now[one : one + PAGE], now[other : other + PAGE] = (
        now[other : other + PAGE],
        now[one : one + PAGE],
    )


def a_page_twice(now: bytearray, files: Files, choice: Random) -> None:
    one, other = page_of(now, choice), page_of(now, choice)
    now[one : one + PAGE] = now[other : other + PAGE]


def a_lost_page(now: bytearray, files: Files, choice: Random) -> None:
    """Fill a page, or a sector, with zeros or noise."""
    size = choice.choice((512, PAGE))
    at = size * choice.randrange(len(now) // size)
    now[at : at + size] = choice.choice((bytes(size), choice.randbytes(size)))


def cut_off(now: bytearray, files: Files, choice: Random) -> None:
    if choice.random() < 0.2:
        now += choice.randbytes(choice.choice((1, 700, PAGE)))
    else:
        size = choice.choice((1, PAGE))
        del now[size * choice.randrange(len(now) // size) :]


def torn(now: bytearray, files: Files, choice: Random) -> None:
    """Leave the first pages as they are now, and the others as they were; or the other way."""
    before, at = choice.choice(files[:-1]), page_of(now, choice)
    if choice.random() < 0.5:
        now[at:] = before[at:]
    else:
        now[:at] = before[:at]


def lost_writes(now: bytearray, files: Files, choice: Random) -> None:
    """Leave a few pages as they were."""
    before = choice.choice(files[:-1])
    for _ in range(choice.choice((1, 1, 2, 5))):
        at = page_of(before, choice)
        now[at : at + PAGE] = before[at : at + PAGE]


def other_journal(now: bytearray, files: Files, choice: Random) -> None:
    """Leave a journal of a write that was broken off at another time."""
    journal = JOURNALS[choice.randrange(len(files))]
    if choice.random() < 0.3:
        journal = journal[: choice.randrange(len(journal))]
    JOURNAL.write_bytes(journal)


OF_TWO_TIMES = torn, lost_writes, other_journal
FILE_CHANGES: tuple[Callable[[bytearray, Files, Random], None], ...] = (
    *(some_bytes, some_bytes, a_header, exchanged_pages, a_page_twice, a_lost_page, cut_off),
    *OF_TWO_TIMES,
)


def exchanged_cells(path: Path, choice: Random) -> None:
    """Exchange the values of two rows in a column or two, as an editor of tables might."""
    table, columns = choice.choice(
        (
            ("capture", ("path", "location")),
            ("capture", ("label", "said")),
            ("capture", ("sha256",)),
            ("capture", ("heading",)),
            ("capture", ("tracks", "content", "checksum")),
            ("track", ("part",)),
            ("track", ("symbols", "checksum")),
            ("track", ("known",)),
            ("symbol_code", ("start",)),
            ("symbol_code", ("sign", "notes")),
            ("segment", ("listing", "checksum")),
            *[("segment_column", ("content",))] * 4,
            ("segment_column", ("name",)),
            ("segment_column", ("part",)),
            ("metadata", ("value",)),
            ("profile", ("name",)),
        )
    )
    names = ", ".join(columns)
    with closing(sqlite3.connect(path)) as connection, connection:
        key = "rowid"
        if table in ("track", "symbol_code", "metadata"):  # tables without rowid
            keys = {"track": "capture_id, ordinal", "metadata": "capture_id, key"}
            key = f"({keys.get(table, 'capture_id, track, ordinal')})"
        plain = key.strip("()")
        held = connection.execute(f"SELECT {names}, {plain} FROM {table}").fetchall()
        one, other = choice.choice(held), choice.choice(held)
        width = len(columns)
        for values, row in ((one[:width], other), (other[:width], one)):
            change = ", ".join(f"{name} = ?" for name in columns)
            marks = ", ".join("?" * len(row[width:]))
            where = f"{key} = ({marks})" if key != plain else f"{key} = ?"
            connection.execute(
                f"UPDATE {table} SET {change} WHERE {where}", (*values, *row[width:])
            )


def statements(path: Path, choice: Random) -> None:
    """Do what a person might who knows some SQL."""
    number = choice.randint(1, 6)
    change = choice.choice(
        (
            f"DELETE FROM capture WHERE id = {number}",
            f"UPDATE capture SET label = 'walk' WHERE id = {number}",
            f"UPDATE capture SET path = 'in/other.bvh' WHERE id = {number}",
            f"UPDATE capture SET id = id + 100 WHERE id = {number}",
            f"UPDATE track SET capture_id = 1 + capture_id % 6 WHERE capture_id = {number}",
            f"DELETE FROM symbol_code WHERE capture_id = {number}",
            f"DELETE FROM track WHERE capture_id = {number}",
            f"UPDATE symbol_code SET sign = sign + 1 WHERE capture_id = {number}",
            "UPDATE symbol_code SET start = start + 1",
            "DELETE FROM metadata",
            "UPDATE metadata SET value = 'Ada'",
            "DELETE FROM segment_pending",
            "DELETE FROM segment_dead",
            "DELETE FROM segment",
            "DELETE FROM segment_column",
            f"UPDATE segment_dead SET segment_id = {number}",
            f"UPDATE segment_dead SET capture_id = {number}",
            f"UPDATE segment_pending SET capture_id = {number}",
            "UPDATE state SET stamp = 0",
            "UPDATE state SET stamp = 0, columns = 0",
            "UPDATE state SET captures = captures - 1",
            "DROP TABLE segment_dead",
            "DROP TABLE profile",
            "DROP TABLE state",
            "DROP INDEX ix_capture_path",
            "ALTER TABLE capture RENAME COLUMN label TO title",
            "ALTER TABLE capture ADD COLUMN more TEXT",
            "DELETE FROM alembic_version",
            "UPDATE alembic_version SET version_num = '0003'",
        )
    )
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(f"{change}")


def other_pages(path: Path, choice: Random) -> None:
    """Let the roots of two tables or indices be those of each other."""
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("PRAGMA writable_schema = ON")
        held = connection.execute("SELECT rowid, rootpage FROM sqlite_master WHERE rootpage")
        (one, here), (other, there) = choice.sample(held.fetchall(), 2)
        change = "UPDATE sqlite_master SET rootpage = ? WHERE rowid = ?"
        connection.executemany(change, [(there, one), (here, other)])


TABLE_CHANGES: tuple[Callable[[Path, Random], None], ...] = (
    *(change_a_cell, change_a_cell, take_out_a_row, put_a_row_in_twice, turn_a_bit),
    *(exchanged_cells, exchanged_cells, statements, other_pages),
)

FILES: Files = []
JOURNALS: list[bytes] = []
ANSWERS: list[dict[str, str]] = []


def answer(verb: str) -> tuple[int, str]:
    """Return how a verb ends, and what it prints; where it fails, of the error."""
    shutil.rmtree("clips", ignore_errors=True)
    code = called(*VERBS[verb], "--db", LIBRARY)
    said = errors_of()
    if code == 2:
        assert said.splitlines()[-1].startswith("lanindex: ") or "^" in said, said
        assert _OF_DAMAGE.search(said), said
        return code, said
    told = _SIZE.sub("", Path("stdout").read_text())  # of the file
    for clip in sorted(Path("clips").glob("*")):
        told += f"{clip.name} {clip.read_bytes()!r}\n"
    return code, told


_SIZE = re.compile(r'"size": \d+')
_OF_DAMAGE = re.compile(
    r"damaged|database|not a library|this file is empty|add up to|revision|state is|\^"
)
"""What errors say of damage, and not of memory, or of somebody else who holds the library."""


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Damage a library, and ask it."""
    now = len(FILES) - 1 if choice.random() < 0.7 else choice.randrange(4, len(FILES))
    files = FILES[: now + 1]
    times = {now}
    change = choice.choice((*FILE_CHANGES, *TABLE_CHANGES))
    if change in FILE_CHANGES:
        content = bytearray(files[-1])
        change(content, files, choice)
        LIBRARY.write_bytes(content)
        if change in OF_TWO_TIMES:
            times = {*range(now + 1)}
    else:
        LIBRARY.write_bytes(files[-1])
        try:
            change(LIBRARY, choice)
        except (sqlite3.Error, IndexError):  # what the tables themselves refuse, or an empty one
            return {"refused": 1}
    became, says = Counter[str](), list[str]()
    for verb in choice.sample(list(VERBS), 4):
        code, told = answer(verb)
        if code == 2:
            became["told"] += 1
            says.append(f"{verb}: {told}")
            continue
        fits = {at for at in times if ANSWERS[at][verb] == told}
        if change in OF_TWO_TIMES and not fits:
            became["mixed"] += 1
            continue
        assert fits, (change.__name__, verb, told, [ANSWERS[at][verb] for at in times])
        times = fits
        became["right"] += 1
    code = called("db", "check", "--db", LIBRARY)
    checked = Path("stdout").read_text() + errors_of()
    assert code or not (became["told"] or became["mixed"]), (change.__name__, says, checked)
    if became["mixed"]:
        return {"mixed": 1}
    how = "errors" if not became["right"] else "some errors" if became["told"] else "right answers"
    return {how: 1}


def main() -> int:
    """Make a library, change it a few times, and keep its file each time."""
    options = common.arguments(__doc__.split("\n")[0], 10_000).parse_args()
    with tempfile.TemporaryDirectory() as name:
        with chdir(name):
            prepare()
        return common.run(trial, options)


def prepare() -> None:
    files = common.files(6, 3)
    Path("in").mkdir()

    def ingest(number: int, name: str = "") -> None:
        ending, content = files[number]
        path = Path("in", name or f"{number}{ending}")
        path.write_bytes(content)
        assert called("ingest", path, "--db", LIBRARY) == 0, errors_of()
        keep()

    def label(*what: Any) -> None:
        with Store.open(LIBRARY) as store:
            store.label(*what)
        keep()

    def keep() -> None:
        FILES.append(LIBRARY.read_bytes())
        with closing(sqlite3.connect(LIBRARY)) as connection:
            connection.execute(
                "PRAGMA cache_size = 5"
            )  # so that some is in the file before the end
            connection.execute("UPDATE capture SET label = label || 'x', said = 0")
            connection.execute("UPDATE symbol_code SET start = start + 1")
            JOURNALS.append(JOURNAL.read_bytes())
            connection.rollback()
        told = {verb: answer(verb) for verb in VERBS}
        assert {code for code, _ in told.values()} <= {0, 1}
        assert LIBRARY.read_bytes() == FILES[-1]
        ANSWERS.append({verb: text for verb, (_, text) in told.items()})

    for number in (0, 6, 1):
        ingest(number)
    label(1, "walk", {"who": "Rudolf"})
    label(2, "walk")
    with Store.open(LIBRARY) as store:
        store.cache.compact()
    keep()
    for number in (2, 7, 3):
        ingest(number)
    label(2, "wave", {"who": "Ada", "take": "2"})
    label(1, "wink")
    ingest(5, "0.lnd")
    with Store.open(LIBRARY) as store:
        store.remove(3)
    keep()
    ingest(8)
    label(4, "walk")


if __name__ == "__main__":
    sys.exit(main())
