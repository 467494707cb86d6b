"""The library: captures written down, kept in a database.

``with Library.open("dance.db", create=True) as library: library.add(...)`` is one transaction a
capture: whatever breaks off, the library holds whole captures or none.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import get_ident
from types import TracebackType
from typing import Self

from sqlalchemy import Connection, select

from lanindex.alphabet import PARTS
from lanindex.errors import LibraryError, UsageError
from lanindex.library import read, rows, schema, write
from lanindex.library.connect import (
    DEFAULT,
    Target,
    drop_journal,
    keep_journal,
    opened,
    reading,
    target,
    writing,
)
from lanindex.library.faults import translated
from lanindex.library.find import find_capture, matching, missing
from lanindex.library.stats import Stats, count
from lanindex.model import Capture, Score, Track

_BATCH = 64
"""Captures read at a time by `Library.tracks`."""


@dataclass(frozen=True, slots=True)
class Encoding:
    """How a capture came to be written down; equal ones give equal scores.

    Attributes
    ----------
    profile : str
        Its name; empty for a score that came as one.
    digest : str
        sha256 of the profile's files.
    options : Mapping of str to str
        What the reader was told in place of what it would have found: unit, up, fps, compose.
    """

    profile: str = ""
    digest: str = ""
    options: Mapping[str, str] = field(default_factory=dict)


class Library:
    """Captures and their scores. Made by `open`; belongs to one thread."""

    def __init__(self, where: Target, connection: Connection) -> None:
        self._where, self._connection, self._wrote = where, connection, False
        self._thread = get_ident()

    @classmethod
    def open(
        cls,
        named: str | os.PathLike[str] = DEFAULT,
        *,
        create: bool = False,
        readonly: bool = False,
        timeout: float = 30.0,
    ) -> Self:
        """Open a library; use it as a context manager, or close it.

        Parameters
        ----------
        named : str or path-like
            A file, or an SQLAlchemy URL.
        create : bool
            Make it if there is none.
        readonly : bool
            Refuse to change it.
        timeout : float
            Seconds to wait for another process.

        Returns
        -------
        Library

        Raises
        ------
        LibraryError
            If there is none, it is no library, or it cannot be opened.
        LibraryVersionError
            If it is older or newer than this program.
        LibraryBusyError
            If another process holds it for longer than `timeout`.
        """
        where = target(named)
        return cls(where, opened(where, create=create, readonly=readonly, timeout=timeout))

    def __repr__(self) -> str:
        """Return the class and the place."""
        return f"<Library {self.place}>"

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        self.close()

    @property
    def place(self) -> str:
        """The library as it was named."""
        return self._where.place

    def close(self) -> None:
        """Let go of the database; what is left is one file."""
        if self._connection.closed:
            return
        self._check_usable()
        try:
            if self._wrote:
                with translated(self.place):
                    drop_journal(self._connection)
        finally:
            self._connection.close()
            self._connection.engine.dispose()

    def add(
        self,
        path: str | os.PathLike[str],
        score: Score,
        *,
        format: str,
        sha256: str,
        encoding: Encoding | None = None,
        label: str | None = None,
        metadata: Mapping[str, str] | None = None,
    ) -> int:
        """Store a score, in place of an earlier one of the same path, and return its number.

        Parameters
        ----------
        path : str or path-like
            The capture's file, as given; made absolute, it tells captures apart.
        score : Score
            What was read there.
        format : str
            ``bvh``, ``lnd`` ...
        sha256 : str
            Of the file's bytes, hexadecimal.
        encoding : Encoding, optional
            How it was written down; left out for a score that came as one.
        label : str, optional
            The user's. None keeps what there is.
        metadata : Mapping of str to str, optional
            The user's other columns. None keeps what there is.

        Raises
        ------
        UsageError
            If this score, or what is said of it, cannot be stored.
        LibraryError
            If the library cannot be written. Either way nothing of it is stored.
        """
        shown, encoding = os.fspath(path), encoding or Encoding()
        location = os.path.abspath(shown)
        _check_text(shown, [shown, location, format, sha256, encoding.profile, *score.tracks])
        _check_said(shown, label, metadata)
        rows.check(score, shown)
        values = {
            "path": shown,
            "location": location,
            "format": format,
            "sha256": sha256,
            "profile_id": None,
            "options": json.dumps(dict(encoding.options), sort_keys=True),
            **rows.capture_columns(score),
        }
        with self._changing() as connection:
            if encoding.digest:
                values["profile_id"] = write.put_profile(
                    connection, encoding.profile, encoding.digest
                )
            number = write.put_capture(connection, values, score)
            write.describe(connection, number, label, metadata)
        return number

    def label(
        self,
        which: int | str,
        label: str | None = None,
        metadata: Mapping[str, str] | None = None,
    ) -> bool:
        """Change what the user says of a capture; its score stays.

        Parameters
        ----------
        which : int or str
            Its number or its path, as in `capture`.
        label : str, optional
            None keeps what there is.
        metadata : Mapping of str to str, optional
            All of it, in place of what there is; None keeps that.

        Returns
        -------
        bool
            Whether that changed anything.
        """
        _check_said(self.place, label, metadata)
        before = self.capture(which)
        same = label in (None, before.label) and metadata in (None, before.metadata)
        if not same:
            with self._changing() as connection:
                write.describe(connection, before.id, label, metadata)
        return not same

    def remove(self, *which: int | str) -> None:
        """Take captures out of the library; none where one of them is not there.

        Parameters
        ----------
        *which : int or str
            Numbers or paths, as in `capture`.
        """
        with self._changing() as connection:
            for number in {self._capture(connection, one).id for one in which}:
                write.remove_capture(connection, number)

    def missing(self) -> list[Capture]:
        """Return the captures whose file is no longer where it was ingested."""
        return missing(self.captures())

    def known(self) -> dict[str, tuple[str, Encoding]]:
        """Return what need not be encoded again: by absolute path, sha256 and encoding."""
        capture, profile = schema.capture.c, schema.profile.c
        statement = select(
            capture.location, capture.sha256, capture.options, profile.name, profile.digest
        ).select_from(schema.capture.outerjoin(schema.profile))
        with self._reading() as connection:
            found = connection.execute(statement).all()
        return {
            row.location: (
                row.sha256,
                Encoding(row.name or "", row.digest or "", json.loads(row.options)),
            )
            for row in found
        }

    def captures(self, glob: str | None = None) -> list[Capture]:
        """Return the captures, in the order in which they came.

        Parameters
        ----------
        glob : str, optional
            Only those whose path, absolute path or (without a slash in it) name it fits.
        """
        with self._reading() as connection:
            found = read.read_captures(connection)
        return found if glob is None else matching(found, glob)

    def capture(self, which: int | str) -> Capture:
        """Return one capture.

        Parameters
        ----------
        which : int or str
            Its number, or its path: as ingested, absolute, or the end of it.

        Raises
        ------
        LibraryError
            If there is none, or there are several.
        """
        with self._reading() as connection:
            return self._capture(connection, which)

    def located(self, places: Sequence[str], digests: Sequence[str]) -> list[str]:
        """Return where captures lie that are at one of these places, or have such a sha256."""
        with self._reading() as connection:
            return read.locations(connection, places, digests)

    def tracks(
        self, captures: Iterable[int] | None = None, parts: Iterable[str] | None = None
    ) -> Iterator[tuple[Capture, dict[str, Track]]]:
        """Yield each capture with its tracks, in the order of their numbers.

        Parameters
        ----------
        captures : iterable of int, optional
            Numbers; else all.
        parts : iterable of str, optional
            Only these, which reads less; else all. A part that a capture lacks is left out.
        """
        only = None if parts is None else list(parts)
        with self._reading() as connection:
            numbers = read.capture_numbers(connection)
        if captures is not None:
            numbers = sorted(set(captures).intersection(numbers))
        for first in range(0, len(numbers), _BATCH):
            batch = numbers[first : first + _BATCH]
            with self._reading() as connection:
                chosen = read.read_captures(connection, batch)
                tracks = read.read_tracks(connection, batch, only)
            for capture in chosen:
                yield capture, tracks.get(capture.id, {})

    def score(self, which: int | str) -> Score:
        """Return the score of a capture, field by field as it was stored."""
        with self._reading() as connection:
            return read.read_score(connection, self._capture(connection, which))

    def parts(self) -> list[str]:
        """Return the parts that any capture has, in the order of the alphabet."""
        with self._reading() as connection:
            found = set(connection.scalars(select(schema.track.c.part).distinct()))
        return [part for part in PARTS if part in found] + sorted(found.difference(PARTS))

    def stats(self) -> Stats:
        """Count what the library holds."""
        path = self._where.path
        with self._reading() as connection:
            return count(connection, path.stat().st_size if path else 0)

    def _capture(self, connection: Connection, which: int | str) -> Capture:
        if isinstance(which, int):
            numbers = [which] if which < 1 << 63 else [0]  # more than SQLite counts to
        else:
            which = which.encode("utf-8", "backslashreplace").decode()
            numbers = read.numbers_at(connection, which)
        found = read.read_captures(connection, numbers)
        if len(found) == 1:
            return found[0]
        others = [] if isinstance(which, int) else read.read_captures(connection)
        return find_capture(others, str(which), self.place)

    def _check_usable(self) -> None:
        if self._connection.closed:
            raise LibraryError(
                "this library has been closed", place=self.place, remedy="Open it again."
            )
        if get_ident() != self._thread:
            raise LibraryError(
                "this library was opened in another thread",
                place=self.place,
                remedy="Open it in each thread that uses it.",
            )

    @contextmanager
    def _reading(self) -> Iterator[Connection]:
        self._check_usable()
        with translated(self.place), reading(self._connection):
            yield self._connection

    @contextmanager
    def _changing(self) -> Iterator[Connection]:
        self._check_usable()
        with translated(self.place):
            if not self._wrote:
                keep_journal(self._connection)
                self._wrote = True
            with writing(self._connection):
                yield self._connection


def _check_said(place: str, label: str | None, metadata: Mapping[str, str] | None) -> None:
    _check_text(place, [label or "", *(metadata or {}), *(metadata or {}).values()])


def _check_text(place: str, texts: Iterable[str]) -> None:
    for text in texts:
        try:
            text.encode()
        except UnicodeEncodeError as error:
            raise UsageError(
                f"{_printable(text)} has bytes that are no UTF-8",
                place=_printable(place),
                remedy="Rename the file, or save the table of labels as UTF-8.",
            ) from error


def _printable(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode()
