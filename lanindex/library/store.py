"""The library: captures written down, kept in a database.

``with Store.open("dance.db", create=True) as library: library.add(...)`` is one transaction a
capture: whatever breaks off, the library holds whole captures or none.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from lanindex.alphabet import TRACKS
from lanindex.errors import UsageError
from lanindex.library import read, rows, segments, state
from lanindex.library.called import texts_of
from lanindex.library.choosing import Choosing
from lanindex.library.columns import chosen
from lanindex.library.encoding import Encoding
from lanindex.library.find import (
    Where,
    absent,
    fitting,
    globs,
    is_number,
    missing,
    several,
)
from lanindex.library.link import Link
from lanindex.library.segments import Distrust
from lanindex.library.stats import Stats, count
from lanindex.library.texts import absolute, check_said, check_text, printable
from lanindex.model import Capture, Score, Track
from lanindex.model.columns import Columns, Roster

_BATCH = 256
"""Captures read at a time by `Store.tracks`."""


class Store(Choosing):
    """Captures and their scores. Made by `open`; belongs to one thread."""

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
        warnings: Sequence[str] = (),
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
        warnings : sequence of str, optional
            What the reader found doubtful.

        Raises
        ------
        UsageError
            If this score, or what is said of it, cannot be stored.
        LibraryError
            If the library cannot be written. Either way nothing of it is stored.
        """
        shown, encoding = printable(os.fspath(path)), encoding or Encoding()
        location = absolute(path)
        check_text(shown, [format, sha256, encoding.profile, *score.tracks])
        check_said(shown, label, metadata)
        rows.check(score, shown)
        values = {
            "path": shown,
            "location": location,
            "format": format,
            "sha256": sha256,
            "warnings": json.dumps(list(warnings)),
            **rows.capture_columns(score),
        }
        from lanindex.library import write

        with self._changing() as connection:
            number, new = write.put_capture(connection, values, score, encoding)
            write.describe(connection, number, label, metadata, new)
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
        check_said(self.place, label, metadata)
        before = self.capture(which)
        same = label in (None, before.label) and metadata in (None, before.metadata)
        if not same:
            from lanindex.library import write

            with self._changing() as connection:
                write.describe(connection, before.id, label, metadata)
        return not same

    def move(self, which: int | str, path: str | os.PathLike[str]) -> None:
        """Say that a capture's file is elsewhere now; all that is known of it stays.

        Parameters
        ----------
        which : int or str
            Its number or its path, as in `capture`.
        path : str or path-like
            Where it is, as given; no capture may be known from there.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.move("compass.bvh", "archive/compass.bvh")
        ...     library.capture("compass.bvh").path
        'archive/compass.bvh'
        """
        shown = printable(os.fspath(path))
        from lanindex.library import write

        with self._changing() as connection:
            number = self._stored(connection, which).capture.id
            write.move_capture(connection, number, shown, absolute(path))

    def remove(self, *which: int | str) -> None:
        """Take captures out of the library; none where one of them is not there.

        Parameters
        ----------
        *which : int or str
            Numbers or paths, as in `capture`; of a damaged one the number.
        """
        from lanindex.library import write

        with self._changing() as connection:
            for number in {self._number(connection, one) for one in which}:
                write.remove_capture(connection, number)

    def missing(self) -> list[Capture]:
        """Return the captures whose file is no longer where it was ingested."""
        return missing(self.captures())

    @property
    def stamp(self) -> int:
        """A number that every change raises: what was derived at another one may be out of date."""
        with self._reading() as connection:
            return int(state.read_state(connection).stamp)

    def known(self) -> dict[str, tuple[str, Encoding]]:
        """Return what need not be encoded again: by absolute path, sha256 and encoding.

        In the order of the captures; one that is damaged is left out.
        """
        with self._reading() as connection:
            found = list(read.read_stored(connection))
        return {
            one.capture.location: (one.capture.sha256, one.encoding)
            for one in found
            if isinstance(one, read.Stored)
        }

    def captures(
        self, within: str | None = None, where: Where | None = None, *, doubts: bool = False
    ) -> list[Capture]:
        """Return the captures, in the order in which they came.

        Parameters
        ----------
        within : str, optional
            A glob: only those whose path, absolute path or (without a slash in it) name it fits.
        where : Mapping of str to str, or iterable of (str, str), optional
            Globs that all must fit, by what they are compared with: ``label``, ``format``,
            ``path``, ``dataset`` or any other column that the user gave. One that a capture lacks
            is compared as the empty text.
        doubts : bool
            Only those of which the reader found something doubtful.

        Raises
        ------
        UsageError
            If no capture has such a column.
        LibraryError
            If one of the captures is not what was stored.
        """
        with self._reading() as connection:
            found = [one.capture for one in read.read_captures(connection)]
        places = fitting(texts_of(found), range(len(found)), globs(within, where))
        return [found[place] for place in places if found[place].warnings or not doubts]

    def capture(self, which: int | str) -> Capture:
        """Return one capture.

        Parameters
        ----------
        which : int or str
            Its number, or its path: as ingested, absolute, or the end of it.

        Raises
        ------
        LibraryError
            If there is none, there are several, or it is not what was stored.
        """
        with self._reading() as connection:
            return self._stored(connection, which).capture

    def encoding(self, which: int | str) -> Encoding:
        """Return how a capture was read and written down.

        Parameters
        ----------
        which : int or str
            As of `capture`.

        Raises
        ------
        LibraryError
            As `capture`.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.encoding("greetings.bvh").profile
        'default'
        """
        with self._reading() as connection:
            return self._stored(connection, which).encoding

    def located(self, places: Sequence[str], digests: Sequence[str]) -> list[str]:
        """Return where captures lie that are at one of these places, or have such a sha256."""
        with self._reading() as connection:
            return read.locations(connection, places, digests)

    def tracks(
        self,
        captures: Iterable[int] | None = None,
        parts: Iterable[str] | None = None,
        *,
        listed: bool = True,
    ) -> Iterator[tuple[Capture, dict[str, Track]]]:
        """Yield each capture with its tracks, in the order of their numbers.

        Parameters
        ----------
        captures : iterable of int, optional
            Numbers; else all.
        parts : iterable of str, optional
            Only these, which reads less; else all. A part that a capture lacks is left out.
        listed : bool
            Hold the list of a capture's tracks against its checksum, too, for which all of them are
            read. Where it is not, whoever asks must know what the tracks are.

        Raises
        ------
        LibraryError
            If something of it is not what was stored.
        """
        only = None if parts is None else list(parts)
        if captures is not None:
            numbers = sorted({int(one) for one in captures if is_number(one)})
        else:
            with self._reading() as connection:
                numbers = state.capture_numbers(connection)
        for first in range(0, len(numbers), _BATCH):
            some = numbers[first : first + _BATCH]
            with self._reading() as connection:
                chosen = read.read_captures(connection, some)
                if len(chosen) < len(some):  # were they never there, or lost?
                    state.capture_numbers(connection)
                tracks = read.read_tracks(connection, chosen, only, listed=listed)
            for one in chosen:
                yield one.capture, tracks[one.capture.id]

    def score(self, which: int | str) -> Score:
        """Return the score of a capture, field by field as it was stored.

        Raises
        ------
        LibraryError
            As `capture`.
        """
        with self._reading() as connection:
            return read.read_score(connection, self._stored(connection, which))

    def parts(self, *, checked: bool = True) -> list[str]:
        """Return the parts that any capture has, in the order of the alphabet.

        Parameters
        ----------
        checked : bool
            Hold them against their checksums, which takes longer the more captures there are.

        Raises
        ------
        LibraryError
            If the tracks are not those that were stored.
        """
        with self._reading() as connection:
            names = read.read_parts if checked else segments.part_names
            found = set(names(connection))
        return [part for part in TRACKS if part in found] + sorted(found.difference(TRACKS))

    def check_parts(self, named: Iterable[str]) -> None:
        """Refuse a part that neither the alphabet nor any capture has.

        Raises
        ------
        UsageError
            With those that there are.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.check_parts(["r_arm", "body_turn"])
        """
        for part in named:
            if part not in TRACKS and part not in (held := self.parts(checked=False)):
                wanted = f"one of {' '.join(dict.fromkeys((*TRACKS, *held)))}"
                raise UsageError(f'"{part}"', place="--part", wanted=wanted)

    def columns(
        self,
        parts: Iterable[str],
        numbers: Iterable[int] | None = None,
        *,
        more: Collection[str] = (),
    ) -> tuple[Roster, dict[str, Columns]]:
        """Return captures and what some parts do in them, as columns.

        They come from the library's segments; where these are missing, damaged or out of date, they
        are made anew from the rows, and `tell` is told. They are kept while the library is held
        open, and read again once it has changed.

        Parameters
        ----------
        parts : iterable of str
            Whose; one that no capture has gets columns without rows.
        numbers : iterable of int, optional
            Only these captures; else all.
        more : collection of str
            What of `lanindex.model.columns.EXTRA` is wanted, too: hardly a search asks for it.

        Returns
        -------
        Roster, dict of str to Columns
            The captures in the order of their numbers; by part.

        Raises
        ------
        LibraryError
            If a capture is not what was stored.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     roster, columns = library.columns(["r_arm"])
        >>> len(roster), len(columns["r_arm"].bounds)
        (10, 11)
        """
        wanted = list(dict.fromkeys(parts))
        roster, columns = self._found(wanted, more)
        return (roster, columns) if numbers is None else chosen(roster, columns, list(numbers))

    def stats(self) -> Stats:
        """Count what the library holds."""
        path = self._where.path
        size = path.stat().st_size if path else 0
        try:
            with self._reading() as connection:
                return count(connection, size)
        except Distrust as fault:
            self._doubt = fault.found
        with self._reading() as connection:
            return count(connection, size, trusted=False)

    def _stored(self, connection: Link, which: int | str) -> read.Stored:
        number = self._number(connection, which)
        return read.read_capture(connection, number)

    def _number(self, connection: Link, which: int | str) -> int:
        """Return the number of a capture that is there, damaged or not."""
        if isinstance(which, str):
            named = printable(which)
            for found in read.meant(connection, named):
                if len(found) == 1:
                    return found[0][0]
                if found:
                    raise several(named, [location for _, location in found], self.place)
            raise absent(named, self._places(connection), self.place)
        if is_number(which) and state.read_numbers(connection, [int(which)]):
            return int(which)
        raise absent(str(which), {"path": [], "location": []}, self.place)
