"""A library that looks after its columns: what is in no segment goes there, what is wrong goes.

Nothing here changes what the library says, so the change stamp stays.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import closing
from functools import partial
from typing import Any

from lanindex.errors import LibraryError
from lanindex.library import gather, segments, state
from lanindex.library.columns import Held
from lanindex.library.connect import Target, opened, writing
from lanindex.library.faults import translated
from lanindex.library.gather import Step
from lanindex.library.segments import Distrust
from lanindex.library.session import Session
from lanindex.model.columns import Columns, Roster

MOST_PENDING = 256
"""Captures that a search takes from their rows each time rather than put them into a segment."""

_PATIENCE = 1.0
"""Seconds that a search waits to write."""

_ANEW = "they are made of its symbols now"
_BESIDE = "what is not there is read from the symbols, each time"

Found = tuple[Roster, dict[str, Columns]]


class Keeper(Session):
    """An open library, with its columns.

    Attributes
    ----------
    notes : list of str
        What it had to do about its columns that a user should know, a sentence each.
    tell : callable
        Is given each of these when it comes up, before the work begins; by default they are kept
        in `notes`.
    watch : callable
        Is told what a job that takes long goes through, how much of it is done, and of how much;
        it may raise, which breaks the job off.
    """

    def __init__(self, *where: Any, **how: Any) -> None:
        super().__init__(*where, **how)
        self.notes: list[str] = []
        self.tell: Callable[[str], None] = self.notes.append
        self.watch: Callable[[str, int, int], None] = _unwatched
        self._held, self._mended_at = Held(), -1
        self._doubt = ""  # what was found wrong, and is not mended yet

    def gather(self) -> None:
        """Put all captures into segments, and join those that are small.

        A search reads segments; an ingest ends with this. Whatever it is broken off by, what is
        there is true; where it cannot be done, `tell` is told, and searches take longer.

        Examples
        --------
        >>> import lanindex
        >>> from lanindex.library.migrate import status
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.remove("compass.bvh")
        ...     library.gather()
        >>> status("dance.db").segments, status("dance.db").pending
        (1, 0)
        """
        with self._reading() as connection:
            idle = gather.is_gathered(connection)
        if not idle:
            self._mend("")

    def _step(self, step: Step) -> bool:
        with self._writing() as connection:
            return step(connection)

    def _found(self, parts: Sequence[str], more: Collection[str] = ()) -> Found:
        """Return all captures and the columns of some parts, from wherever they can be trusted."""
        found, fault = self._tried(parts, more, MOST_PENDING)
        fault, self._doubt = fault or self._doubt, ""
        if found is None or fault:
            with self._reading() as connection:
                stamp = int(state.read_state(connection).stamp)
                pending = segments.count_pending(connection)
            if stamp != self._mended_at:
                if not fault:
                    self.tell(f"the library's columns lack {pending} of its captures: {_ANEW}")
                self._mend(fault)
                self._mended_at = stamp
            found, _ = self._tried(parts, more)
        if found is None:
            with self._reading() as connection:
                found = self._held.find(connection, parts, more, trusted=False)
        return found

    def _tried(
        self, parts: Sequence[str], more: Collection[str], most: int | None = None
    ) -> tuple[Found | None, str]:
        """Return what the segments give; else None, and what is wrong with them, if anything is."""
        try:
            with self._reading() as connection:
                held = most is None or self._held.has(connection, parts, more)
                if held or segments.count_pending(connection) <= (most or 0):
                    return self._held.find(connection, parts, more), ""
        except Distrust as fault:
            return None, fault.found
        return None, ""

    def _mend(self, fault: str) -> None:
        """Make the segments what they should be, if that can be written.

        A library that is only to be read is written for a moment, by a connection of its own.
        """
        if fault:
            self._tell_fault(fault)
        try:
            if self._readonly:
                _gather_aside(self._where, fault, self)
            else:
                _gather(self._step, fault, self)
        except LibraryError as error:
            self.tell(f"the library's columns cannot be written ({error.found}): {_BESIDE}")

    def _tell_fault(self, fault: str) -> None:
        """Say what was wrong with the columns."""
        self.tell(f"the library's columns were {fault}: {_ANEW}")


def _unwatched(noun: str, done: int, total: int) -> None:
    """Tell nobody."""


def _gather(run: Callable[[Step], bool], fault: str, keeper: Keeper) -> None:
    """Cover and join what there is to cover and join, after a fault was found or not.

    One that comes up only now is told.
    """
    if fault:
        run(gather.purge)
    try:
        _settle(run, keeper)
    except Distrust as error:
        keeper._tell_fault(error.found)
        run(gather.purge)
        _settle(run, keeper)


def _settle(run: Callable[[Step], bool], keeper: Keeper) -> None:
    left: list[int] = []

    def told(waiting: int) -> None:
        left.append(waiting)
        keeper.watch("captures", left[0] - waiting, left[0])

    while run(partial(gather.cover, told=told)):
        pass
    if left:
        told(0)
    while run(gather.join):
        pass


def _gather_aside(where: Target, fault: str, keeper: Keeper) -> None:
    """Do as `_gather` on another connection, which may write."""
    if where.sqlite and where.path is None:
        raise LibraryError("it is kept nowhere else", place=where.place)
    with closing(opened(where, create=False, readonly=False, timeout=_PATIENCE)) as connection:

        def run(step: Step) -> bool:
            with translated(where.place), writing(connection):
                return step(connection)

        _gather(run, fault, keeper)
