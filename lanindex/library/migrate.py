"""Bring a library to the newest revision, and find damage inside it: what `lanindex db` does.

Alembic is imported only when there is work to do.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LibraryError
from lanindex.library import read, rows, segment_files, segments
from lanindex.library.connect import (
    DEFAULT,
    REVISION,
    Progress,
    Session,
    altering,
    ask,
    connected,
    dialect_of,
    first_values,
    no_progress,
    refuse_revision,
    revision,
    target,
    transaction,
    translated,
)
from lanindex.library.dialect import Link, Target
from lanindex.library.rows import VIEW, view_sql
from lanindex.library.segment_files import Distrust
from lanindex.library.selection import printable
from lanindex.library.store import Store

if TYPE_CHECKING:
    from sqlalchemy import Connection

_PACKAGE = Path(__file__).parents[1]
_FOLDERS = (_PACKAGE / "_migrations", _PACKAGE.parent / "migrations")
"""Where the revisions are: in a wheel, in a checkout."""

_TIMEOUT = 30.0


@dataclass(frozen=True, slots=True)
class Status:
    """How new a library is."""

    place: str
    revision: str
    newest: str
    segments: int = 0
    symbols: int = 0
    pending: int = 0
    fault: str = ""

    @property
    def state(self) -> str:
        """``current``, ``older`` (upgrade it) or ``newer`` (than this program)."""
        if self.revision == self.newest:
            return "current"
        return "older" if self.revision < self.newest else "newer"


def scripts() -> Path:
    """Return the folder of the revisions."""
    for folder in _FOLDERS:
        if (folder / "env.py").is_file():
            return folder
    raise LibraryError(
        "this installation lacks its migrations",
        place=str(_FOLDERS[0]),
        remedy="Install LanIndex again.",
    )


def status(named: str | os.PathLike[str] = DEFAULT) -> Status:
    """Return how new a library is."""
    where = target(named)
    with _connected(where, readonly=True) as connection, transaction(connection):
        held = revision(connection, where.place)
        if held is None:
            refuse_revision(held, where.place)
        if held != REVISION:
            return Status(where.place, str(held), REVISION)
        try:
            spine = segments.read_spine(connection)
        except Distrust as fault:
            return Status(where.place, held, REVISION, fault=fault.found)
        symbols = sum(one.symbols for one in spine.segments)
        return Status(where.place, held, REVISION, len(spine.segments), symbols, len(spine.pending))


def upgrade(named: str | os.PathLike[str] = DEFAULT) -> Status:
    """Bring a library to the newest revision, in one transaction, and return its status.

    Of one that has it, columns that cannot be trusted or are an earlier version's are made anew,
    and so is the view in words.
    """
    where = target(named)
    before = status(named)
    if before.state == "newer":
        refuse_revision(before.revision, where.place)
    with _connected(where, readonly=False) as link:
        dialect = dialect_of(link)
        if before.state == "older":
            dialect.before_rebuilding(link)
            with altering(link) as connection:
                # Another process may have done it meanwhile
                if revision(link, where.place) != REVISION:
                    run(connection, "head", where.place)
                    if loose := _loose_rows(link):
                        raise LibraryError(
                            f"after the upgrade {len(loose)} rows would hang on nothing",
                            place=where.place,
                            remedy="Nothing was changed. Ask for what is wrong with: "
                            "lanindex db check",
                        )
            dialect.give_back_room(link)
        else:
            with transaction(link):
                shows_all = _has_view(link)
            if not shows_all:
                with transaction(link, writes=True):
                    dialect.make_view(link, VIEW, view_sql())
    with Store.open(named) as store:
        store.cache.renew()
    return status(named)


def run(connection: Connection, to: str, place: str) -> None:
    """Run the revisions up to one of them."""
    from alembic import command
    from alembic.config import Config
    from alembic.util import CommandError

    link: Link = connection.connection.driver_connection
    config = Config()
    config.set_main_option("script_location", str(scripts()).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    try:
        # Tables under a view cannot be rebuilt. It shows what they hold and holds nothing itself:
        # the revisions know nothing of it.
        if dialect_of(link).view(link, VIEW) is not None:
            ask(link, f"DROP VIEW {VIEW}")
        command.upgrade(config, to)
        if revision(link, place) == REVISION:
            dialect_of(link).make_view(link, VIEW, view_sql())
    except CommandError as error:
        raise LibraryError(
            f"no way leads from its revision to {to}: {error}",
            place=place,
            remedy="Ingest the captures into a new library: all in it comes from them.",
        ) from error


@contextmanager
def _connected(where: Target, *, readonly: bool) -> Iterator[Link]:
    link = connected(where, create=False, readonly=readonly, timeout=_TIMEOUT)
    with closing(link), translated(where.place):
        yield link


def keep_columns(
    named: str | os.PathLike[str], where: str, note: Callable[[str], None] | None = None
) -> None:
    """Keep the columns of a library in files at a place, or (empty) in the library."""
    with Store.open(named, note=note) as store:
        store.cache.move(where)
    with _connected(target(named), readonly=False) as link:
        dialect_of(link).give_back_room(link)


def files_of_columns(named: str | os.PathLike[str]) -> tuple[str, int, int]:
    """Return where the files of columns are, how many, and their bytes; empty: there are none."""
    with closing(Session(target(named), readonly=True)) as session, session.reading() as connection:
        stored = segments.read_spine(connection).segments
        place = segment_files.current_place(connection)
        return place, sum(bool(one.file) for one in stored), sum(one.bytes for one in stored)


_MOST = 5
"""Lines of each kind of damage."""

_BATCH = 1024
"""Captures whose rows are read at once."""

Damage = list[tuple[int, str]]
"""By the number of a capture, a sentence on what is damaged."""


def check(named: str | os.PathLike[str] = DEFAULT, progress: Progress = no_progress) -> list[str]:
    """Return what is wrong inside a library, a sentence each; an empty list if nothing is."""
    with closing(Session(target(named), readonly=True)) as session, session.reading() as connection:
        return _check_connection(connection, progress)


def _check_connection(connection: Link, progress: Progress) -> list[str]:
    if pages := dialect_of(connection).damaged_pages(connection, _MOST, partial(progress, "pages")):
        # Answers of a damaged file to other questions mean nothing.
        return [f"the file is damaged: {line}" for line in pages]
    state, damage, unlike, symbols = list[str](), Damage(), list[str](), 0
    try:
        read.capture_numbers(connection)
    except LibraryError as error:
        state = [str(error)]
    numbers = first_values(ask(connection, "SELECT id FROM capture ORDER BY id"))
    progress("captures", 0, len(numbers))
    compared = set[int]()
    try:
        for segment, stored in _pieces_of_segments(connection):
            some = stored.roster.number
            for piece in _pieces_of_rows(connection, some.tolist(), damage):
                symbols += sum(map(len, piece.columns.values()))
                own = piece.roster.number
                if not piece.same_as(stored.at(np.flatnonzero(np.isin(some, own)))):
                    unlike.append(
                        f"the columns of captures {own[0]} to {own[-1]} in segment {segment} are "
                        "not those of their rows, wanted the same. Have them made anew: "
                        "UPDATE state SET columns = -1"
                    )
            compared.update(some.tolist())
            progress("captures", len(compared), len(numbers))
    except Distrust as fault:
        remedy = fault.remedy or "They are made anew by: lanindex db upgrade"
        unlike = [f"the columns are {fault.found}. {remedy}"]
    except LibraryError:  # Of the library's state, which is noted above
        pass
    rest = [number for number in numbers if number not in compared]
    for first in range(0, len(rest), _BATCH):
        for piece in _pieces_of_rows(connection, rest[first : first + _BATCH], damage):
            symbols += sum(map(len, piece.columns.values()))
        done = len(compared) + min(first + _BATCH, len(rest))
        progress("captures", done, len(numbers))
    tables = ["capture", "metadata", "track"]
    ((count,),) = ask(connection, "SELECT count(*) FROM symbol_code")
    if damage or count != symbols:  # Not looked at otherwise: there are many
        tables.append("symbol_code")
    bonds = [bond for table in tables for bond in _loose_rows(connection, table)]
    loose = "a row of {0} hangs on a row of {1} that does not exist"
    profiles = (
        "SELECT name FROM profile WHERE NOT EXISTS "
        "(SELECT 1 FROM capture WHERE capture.profile_id = profile.id)"
    )
    spare = [printable(str(name)) for name in first_values(ask(connection, profiles))]
    view = (
        "the view symbol does not show what the library holds. "
        "It is made anew by: lanindex db upgrade"
    )
    lines = [
        [loose.format(*bond) for bond in bonds],
        state + [line for _, line in sorted(damage)],
        [f"the profile {name} wrote nothing down" for name in spare],
        [] if _has_view(connection) else [view],
        unlike,
    ]
    return [line for some in lines for line in _shorten(some)]


def _shorten(lines: list[str]) -> list[str]:
    return lines[:_MOST] + ([f"… and {len(lines) - _MOST} more like it"] if lines[_MOST:] else [])


def _pieces_of_segments(connection: Link) -> Iterator[tuple[int, segments.Piece]]:
    """Yield the captures that the segments hold, some at a time, with the number of the segment."""
    spine = segments.read_spine(connection)
    segments.check_files(spine)
    rosters, _ = segments.read_rosters(connection, spine)
    for segment, roster in zip(spine.segments, rosters, strict=True):
        held = {part: segments.read_columns(connection, segment, part) for part in segment.parts}
        whole = segments.Piece(roster, held, segments.read_texts(connection, segment))
        order = segments.alive(spine, segment, roster.number)
        for first in range(0, len(order), _BATCH):
            yield segment.id, whole.at(order[first : first + _BATCH])


def _pieces_of_rows(
    connection: Link, numbers: list[int], damage: Damage
) -> Iterator[segments.Piece]:
    """Yield captures from their rows, at once if none is damaged; note the damage of the others."""
    try:
        chosen = read.read_captures(connection, numbers)
        if len(chosen) != len(numbers):  # The table has it, but its index does not
            raise rows.damaged(numbers[0], None, "its row")
        tracks = read.read_track_rows(connection, chosen)
        symbols = read.read_symbols(connection, tracks)
        for _ in read.read_contents(connection, chosen):
            pass
        damage += _senseless_symbols(tracks, symbols)
        piece = segments.of_rows(tracks, symbols)
    except LibraryError as error:
        if len(numbers) == 1:
            damage.append((numbers[0], str(error)))
            return
        half = len(numbers) // 2
        for some in (numbers[:half], numbers[half:]):
            yield from _pieces_of_rows(connection, some, damage)
    else:
        yield piece


def _senseless_symbols(tracks: read.TrackRows, symbols: NDArray[Any]) -> Iterator[tuple[int, str]]:
    """Yield symbols that were stored with a right checksum but make no sense, by capture."""
    frames = np.array([one.capture.frames for one in tracks.chosen], np.int64)[tracks.place]
    if {*tracks.kind} <= {*range(len(rows.KIND_NAMES))} and not (
        rows.wrong(symbols, frames.repeat(tracks.symbols)).any()
    ):
        return
    every = read.tracks_of(tracks, symbols)
    for capture in (one.capture for one in tracks.chosen):
        for part, track in every[capture.id].items():
            for row in np.flatnonzero(rows.wrong(track.symbols, capture.frames)):
                yield capture.id, f"{capture.path}: {part}, symbol {row} is {track.symbols[row]}"


def _loose_rows(link: Link, table: str = "") -> list[tuple[str, str]]:
    """Return, by row of a table, or of all, that refers to a row that does not exist, both tables.

    SQLite and PostgreSQL refuse such rows, but not where that has been switched off.
    """
    from lanindex.library.schema import tables

    loose = list[tuple[str, str]]()
    for one in [tables.tables[table]] if table else tables.sorted_tables:
        for key in one.foreign_key_constraints:
            pairs = [(it.parent.name, it.column.name) for it in key.elements]
            same = " AND ".join(f"there.{there} = here.{here}" for here, there in pairs)
            known = " AND ".join(f"here.{here} IS NOT NULL" for here, _ in pairs)
            asked = (
                f"SELECT count(*) FROM {one.name} here WHERE {known} "
                f"AND NOT EXISTS (SELECT 1 FROM {key.referred_table.name} there WHERE {same})"
            )
            ((count,),) = ask(link, asked)
            loose += [(one.name, key.referred_table.name)] * count
    return loose


def _has_view(link: Link) -> bool:
    """Return whether the view is that of this version."""
    return dialect_of(link).view(link, VIEW) == view_sql()
