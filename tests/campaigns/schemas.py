"""Libraries in schemas of a PostgreSQL server where campaigns name files, as the tests do it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol

from lanindex.library import connect

WORD = "postgres"
"""What ``--db`` is for a server that is started for the campaign."""


class Server(Protocol):
    """Where schemas are."""

    def url(self, schema: str) -> str:
        """Return the address of a library in a schema."""

    def connect(self, **options: object) -> Any:
        """Return a connection of psycopg."""


class Given:
    """A server by its address."""

    def __init__(self, address: str) -> None:
        import sqlalchemy

        self.address = sqlalchemy.make_url(address)

    def url(self, schema: str) -> str:
        """Return the address of a library in a schema."""
        found = self.address.update_query_dict({"options": f"-csearch_path={schema}"})
        return found.render_as_string(hide_password=False)

    def connect(self, **options: object) -> Any:
        """Return a connection of psycopg."""
        import psycopg

        plain = self.address.set(drivername="postgresql").render_as_string(hide_password=False)
        return psycopg.connect(plain, **options)


@contextmanager
def served(db: str) -> Iterator[Schemas | None]:
    """Let the names of files mean schemas of a server, if one is named."""
    if not db:
        yield None
    elif db == WORD:
        from postgres_server import serving

        with serving() as server:
            yield Schemas(server)
    else:
        yield Schemas(Given(db))


class Schemas:
    """The schemas of a server, by the path of the file that each is there for."""

    def __init__(self, server: Server) -> None:
        self.server = server
        self.made = set[str]()
        connect.in_file = self.target

    def target(self, path: str) -> connect.Target:
        """Return where the library of a path is; its schema is made if it is not there."""
        name = self.name(path)
        if name not in self.made:
            self.run(f"CREATE SCHEMA IF NOT EXISTS {name}")
            self.made.add(name)
        return connect.Target(path, self.server.url(name), None)

    def name(self, path: str | Path) -> str:
        """Return the name of a schema."""
        return f"l{sha256(os.path.abspath(path).encode()).hexdigest()[:20]}"

    def run(self, script: str, path: str | Path = "") -> None:
        """Run SQL; in the schema of a path, if one is given."""
        with self.server.connect(autocommit=True) as link:
            if path:
                link.execute(f"SET search_path = {self.name(path)}")
            link.execute(script)

    def drop(self, path: str | Path) -> None:
        """Delete a library, if there is one."""
        self.run(f"DROP SCHEMA IF EXISTS {self.name(path)} CASCADE")
        self.made.discard(self.name(path))

    def wait(self, path: str | Path) -> None:
        """Wait until a server has ended what somebody who was killed has begun to write."""
        name = self.name(path)
        self.run(f"SELECT pg_advisory_xact_lock(hashtext('lanindex'), hashtext('{name}'))")
