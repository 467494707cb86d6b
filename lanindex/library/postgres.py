"""A library in PostgreSQL, which many machines share: by psycopg.

A reader's transaction is ``REPEATABLE READ READ ONLY``: it sees the state with which it began.
Writers take one lock, which belongs to the library's schema and goes with their transaction; so
they come one after the other, as in SQLite, and never fail halfway. Nobody waits for a reader.

``options=-csearch_path=NAME`` in the URL names a schema: a database may hold several libraries.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LibraryError, extra
from lanindex.library.dialect import Dialect, Link, Target, Values

if TYPE_CHECKING:
    import sqlalchemy

_WAIT = 10
"""Seconds to wait for the server to answer, where the URL does not say."""

_LINK = {
    "keepalives_idle": 30,
    "keepalives_interval": 10,
    "keepalives_count": 3,
    "tcp_user_timeout": 30_000,  # milliseconds
}
"""After a minute or less a link that is cut is an error; a system alone waits up to two hours."""

_READ = "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY"
_WRITE = "BEGIN ISOLATION LEVEL READ COMMITTED"  # the next statements see what was committed before
_LOCK = "SELECT pg_advisory_xact_lock(hashtext('lanindex'), hashtext(current_schema()))"

_REFUSALS = {
    "too many|connection slots": "53300",
    "starting up|shutting down|recovery mode": "57P03",
    "database .* does not exist": "3D000",
    "FATAL|password": "28000",
}
"""SQLSTATE by what is in an error of connecting, with which libpq passes none on."""


class Postgres(Dialect):
    """PostgreSQL."""

    damage = ("XX001", "XX002")

    def connect(self, target: Target, *, create: bool, readonly: bool, timeout: float) -> Link:
        """Connect to a server, which may take a while."""
        with extra("postgres", target.place, LibraryError):
            import psycopg
        said: dict[str, Any] = {"connect_timeout": _WAIT, "client_encoding": "utf8"}
        said |= {"application_name": "lanindex", **_LINK, **target.login}
        link = psycopg.connect(**said, autocommit=True)  # `begin` begins a transaction
        link.execute(f"SET lock_timeout = {max(1, round(timeout * 1000))}")
        if readonly:
            link.execute("SET default_transaction_read_only = on")
        return link

    def engine(self, link: Link) -> sqlalchemy.Engine:
        """Return an engine on this connection."""
        import sqlalchemy

        return sqlalchemy.create_engine(
            "postgresql+psycopg://",
            creator=lambda: link,
            poolclass=sqlalchemy.StaticPool,
            use_native_hstore=False,
        )

    def begin(self, link: Link, *, writes: bool, snapshot: str = "") -> None:
        """Begin a transaction."""
        link.execute(_WRITE if writes else _READ)
        if writes:
            link.execute(_LOCK)
        if snapshot:
            quoted = snapshot.replace("'", "''")
            link.execute(f"SET TRANSACTION SNAPSHOT '{quoted}'")

    def snapshot(self, link: Link) -> str:
        """Return the name of the state that the transaction sees."""
        ((name,),) = link.execute("SELECT pg_export_snapshot()")
        return str(name)

    def end(self, link: Link) -> None:
        """Undo what has not been committed."""
        if not link.closed:
            link.rollback()

    def is_broken(self, link: Link) -> bool:
        """Return whether the server has gone or cut the connection, as far as it has told."""
        import psycopg

        try:
            for _ in range(2):  # a last message, then the end; it waits for neither
                link.pgconn.consume_input()
        except psycopg.OperationalError:
            return True
        return bool(link.closed)

    def ask(self, link: Link, statement: str, values: Values | None) -> Any:
        """Execute a statement; what it returns comes in binary."""
        cursor = link.cursor(binary=True)
        if values is None:
            return cursor.execute(statement)
        if isinstance(values, Mapping):
            return cursor.execute(_named(statement), values)
        cursor.executemany(_named(statement), values)
        return cursor

    def insert(
        self, link: Link, table: str, names: Sequence[str], rows: Sequence[Sequence[Any]]
    ) -> None:
        """Write rows by COPY, which is several times faster than INSERT, but for one alone."""
        if len(rows) == 1:
            values = ", ".join([f":{name}" for name in names])
            statement = f"INSERT INTO {table} ({', '.join(names)}) VALUES ({values})"
            self.ask(link, statement, dict(zip(names, rows[0], strict=True)))
        elif rows:
            with link.cursor().copy(f"COPY {table} ({', '.join(names)}) FROM STDIN") as copy:
                for row in rows:
                    copy.write_row(row)

    def last_number(self, link: Link, table: str) -> int:
        """Return the highest number that a row has ever had."""
        ((name,),) = link.execute("SELECT pg_get_serial_sequence(%s, 'id')", [table])
        ((number, used),) = link.execute(f"SELECT last_value, is_called FROM {name}")
        return int(number) if used else 0

    def go_on_after(self, link: Link, table: str, number: int) -> None:
        """Set the sequence of a table's numbers."""
        if number:
            link.execute("SELECT setval(pg_get_serial_sequence(%s, 'id'), %s)", [table, number])

    def fault(self, error: BaseException) -> str:
        """Return the SQLSTATE of an error, also of one of the driver, which tells none."""
        if state := getattr(error, "sqlstate", None):
            return str(state)
        kind, told = type(error).__name__, str(error)
        if kind not in ("OperationalError", "ConnectionTimeout"):
            return {"DataError": "22000", "ProgrammingError": "08000"}.get(kind, "")
        return next((it for words, it in _REFUSALS.items() if re.search(words, told)), "08000")

    def tables(self, link: Link) -> set[str]:
        """Return the names of all tables of the library's schema."""
        asked = "SELECT tablename FROM pg_tables WHERE schemaname = current_schema()"
        return {name for (name,) in link.execute(asked)}

    def view(self, link: Link, name: str) -> str | None:
        """Return the statement that made a view, which is noted beside it."""
        asked = (
            "SELECT obj_description(c.oid) FROM pg_class c WHERE relname = %s "
            "AND relkind = 'v' AND relnamespace = current_schema()::regnamespace"
        )
        row = link.execute(asked, [name]).fetchone()
        return row and (row[0] or "")

    def make_view(self, link: Link, name: str, statement: str) -> None:
        """Make a view, and note the statement: the server keeps it in words of its own."""
        link.execute(f"DROP VIEW IF EXISTS {name}")
        link.execute(statement)
        quoted = statement.replace("'", "''")
        link.execute(f"COMMENT ON VIEW {name} IS '{quoted}'")

    def numbers(self, link: Link, names: Sequence[str], chosen: str) -> NDArray[np.int64] | None:
        """Return rows of symbols as bytes of each capture, which numpy reads as an array.

        Rows one by one, by COPY, too, take the driver twenty times as long.
        """
        row = " || ".join(f"int8send({name})" for name in names)
        asked = (
            f"SELECT string_agg({row}, ''::bytea ORDER BY track, ordinal) FROM symbol_code "
            f"WHERE {chosen} GROUP BY capture_id ORDER BY capture_id"
        )
        content = b"".join(rows for (rows,) in self.ask(link, asked, None))
        return np.frombuffer(content, ">i8").reshape(-1, len(names)).astype(np.int64)

    def damaged_pages(self, link: Link, most: int, watch: Callable[[int, int], None]) -> list[str]:
        """Return nothing: the server checks each page that it reads, if its owner wants that."""
        return []

    def size(self, link: Link) -> int:
        """Return the bytes of all tables with their indexes."""
        asked = (
            "SELECT sum(pg_total_relation_size(c.oid)) FROM pg_class c "
            "WHERE relkind = 'r' AND relnamespace = current_schema()::regnamespace"
        )
        ((size,),) = link.execute(asked)
        return int(size or 0)

    def folder(self, link: Link) -> Path | None:
        """Return None: the server keeps many files."""
        return None

    def moment(self, link: Link) -> int:
        """Return the number of the transaction."""
        ((number,),) = link.execute("SELECT pg_current_xact_id()::text::bigint")
        return int(number)

    def oldest_reader(self, link: Link, spared: float) -> float:
        """Return the oldest number that a transaction which goes on may still look at."""
        # Readers have no number of their own, so the snapshot of this transaction does not know
        # of them; the server tells what each of them holds, to roles that may see the statistics
        # of others (pg_read_all_stats). All numbers but the newest are told by their lower 32 bits.
        asked = """WITH newest AS (SELECT pg_snapshot_xmax(pg_current_snapshot())::text::bigint x)
            SELECT min(x - ((x - backend_xmin::text::bigint) & 4294967295))
            FROM newest, pg_stat_activity WHERE backend_xmin IS NOT NULL"""
        ((number,),) = link.execute(asked)
        return float(number or 0)

    def before_rebuilding(self, link: Link) -> None:
        """Do nothing: PostgreSQL changes a table as it is."""

    def before_writing(self, link: Link) -> None:
        """Do nothing: the server keeps the journal."""

    def after_writing(self, link: Link) -> None:
        """Do nothing: the server keeps the journal."""

    def give_back_room(self, link: Link) -> None:
        """Do nothing: the server does so by itself (autovacuum)."""


POSTGRES = Postgres()

_NAME = re.compile(r"(?<![:\w]):(\w+)")


@lru_cache(maxsize=256)
def _named(statement: str) -> str:
    """Return a statement with values named as psycopg has them."""
    return _NAME.sub(r"%(\1)s", statement.replace("%", "%%"))
