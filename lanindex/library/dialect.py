"""What a library needs of a database beyond the SQL that SQLite and PostgreSQL share.

`lanindex.library.sqlite` and `lanindex.library.postgres` have it; all other modules know neither.
"""

from __future__ import annotations

import os
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from urllib.parse import parse_qs, unquote

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import sqlalchemy

MEMORY = ":memory:"

MOST = 999
"""Values in one statement: any SQLite takes so many."""

LOGIN = re.compile(
    r"(?:(?P<user>[^:/@?]*)(?::(?P<password>[^@]*))?@)?"
    r"\[?(?P<host>(?<=\[)[^]]*|[^][/:?]*)\]?(?::(?P<port>\d*))?"
    r"(?:/(?P<dbname>[^?]*))?(?:\?(?P<more>.*))?"
)
"""What follows ``://`` in the URL of a server, by the names that PostgreSQL has for it.

PostgreSQL's own parser refuses addresses that SQLAlchemy takes; SQLAlchemy takes longer to import
than a search takes.
"""

Link: TypeAlias = Any
"""A connection of the database's own driver: of `sqlite3`, of `psycopg`."""

Values = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""Of one statement, or of the same one many times."""


@dataclass(frozen=True, slots=True)
class Target:
    """Where a library is."""

    place: str
    """As messages show it: without a password."""

    url: str
    """Empty for SQLite."""

    path: Path | None

    @property
    def name(self) -> str | os.PathLike[str]:
        """What opens the same library again."""
        return self.url or self.place

    @property
    def in_memory(self) -> bool:
        """Whether it is in the memory of this process alone."""
        return not self.url and self.path is None

    @property
    def title(self) -> str:
        """Its short name: of the file, or of the database and its schema."""
        return ".".join(self._named()[2:]) if self.url else Path(self.place).stem

    def beside(self, kind: str) -> Path:
        """Return where something of its owner's is kept that is no part of the library.

        That is beside the library's file; for a library on a server, in a folder of the user's.
        """
        if not self.url:
            path = Path(self.place).absolute()
            return path.with_name(f"{path.stem}-{kind}")
        of_user = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
        same = sha256(repr(self._named()).encode()).hexdigest()[:8]  # whoever connects, and how
        safe = re.sub(r"[^\w.-]", "_", self.title)
        return Path(of_user) / "lanindex" / f"{safe}-{same}" / kind

    @property
    def login(self) -> dict[str, str]:
        """What the URL of a server says, by the names that PostgreSQL has for it."""
        found = LOGIN.fullmatch(self.url.partition("://")[2])
        assert found, self.place
        said = {name: unquote(value) for name, value in found.groupdict().items() if value}
        more = parse_qs(said.pop("more", ""), keep_blank_values=True)
        return said | {name: ",".join(values) for name, values in more.items()}

    def _named(self) -> list[str]:
        """Return the server, its port, the database, and the schema if the URL names one."""
        said = self.login
        schema = re.search(r"search_path=(\S+)", said.get("options", ""))
        where = [said.get(name, "") for name in ("host", "port", "dbname")]
        return [*where, *(schema.groups() if schema else ())]


class Dialect(ABC):
    """A kind of database. Transactions are begun and ended by `begin` and `end` alone."""

    damage: tuple[str, ...]
    """How the names of errors begin (see `fault`) that tell of damage in the database."""

    @abstractmethod
    def connect(self, target: Target, *, create: bool, readonly: bool, timeout: float) -> Link:
        """Connect; `timeout` is how many seconds a transaction waits for another one."""

    @abstractmethod
    def engine(self, link: Link) -> sqlalchemy.Engine:
        """Return an engine of SQLAlchemy whose connections are all this one; it ends nothing."""

    @abstractmethod
    def begin(self, link: Link, *, writes: bool, snapshot: str = "") -> None:
        """Begin a transaction that sees one state, if named that of a `snapshot`.

        One that writes waits for others that do.
        """

    @abstractmethod
    def snapshot(self, link: Link) -> str:
        """Return the name of the state that a transaction sees, for others while it goes on.

        Empty where it has none.
        """

    @abstractmethod
    def end(self, link: Link) -> None:
        """Undo what has not been committed."""

    @abstractmethod
    def is_broken(self, link: Link) -> bool:
        """Return whether nothing can be asked of a connection any more."""

    @abstractmethod
    def ask(self, link: Link, statement: str, values: Values | None) -> Any:
        """Execute a statement with ``:name`` for a value; return a cursor of plain tuples."""

    @abstractmethod
    def insert(
        self, link: Link, table: str, names: Sequence[str], rows: Sequence[Sequence[Any]]
    ) -> None:
        """Write rows."""

    @abstractmethod
    def last_number(self, link: Link, table: str) -> int:
        """Return the highest number that a row of a table has ever had."""

    @abstractmethod
    def go_on_after(self, link: Link, table: str, number: int) -> None:
        """Let new rows of a table have higher numbers than this one."""

    @abstractmethod
    def fault(self, error: BaseException) -> str:
        """Return the database's name of an error: ``SQLITE_BUSY``, ``55P03``."""

    @abstractmethod
    def tables(self, link: Link) -> set[str]:
        """Return the names of all tables."""

    @abstractmethod
    def view(self, link: Link, name: str) -> str | None:
        """Return the statement that made a view; None: there is none."""

    @abstractmethod
    def make_view(self, link: Link, name: str, statement: str) -> None:
        """Make a view, in place of an earlier one."""

    @abstractmethod
    def numbers(self, link: Link, names: Sequence[str], chosen: str) -> NDArray[np.int64] | None:
        """Return rows of ``symbol_code`` that a condition chooses, in order of their keys: (S, C).

        None where they may be damaged.
        """

    @abstractmethod
    def damaged_pages(self, link: Link, most: int, watch: Callable[[int, int], None]) -> list[str]:
        """Return the damage that the database itself finds, a line each, so many at the most.

        `watch` is called with how many pages are done, and of how many; it may raise.
        """

    @abstractmethod
    def size(self, link: Link) -> int:
        """Return how many bytes a library takes."""

    @abstractmethod
    def folder(self, link: Link) -> Path | None:
        """Return the folder of the library's file; None: it is in no file of its own."""

    @abstractmethod
    def moment(self, link: Link) -> int:
        """Return when this transaction is: a number that later ones exceed."""

    @abstractmethod
    def oldest_reader(self, link: Link, spared: float) -> float:
        """Return the moment below which no transaction that goes on can have begun.

        Where nothing tells of readers, that is `spared` seconds ago.
        """

    @abstractmethod
    def before_rebuilding(self, link: Link) -> None:
        """Prepare for changes of tables, outside a transaction."""

    @abstractmethod
    def before_writing(self, link: Link) -> None:
        """Prepare for a transaction that writes."""

    @abstractmethod
    def after_writing(self, link: Link) -> None:
        """Leave nothing behind of transactions that wrote."""

    @abstractmethod
    def give_back_room(self, link: Link) -> None:
        """Make the library as small as its content, where that is possible."""
