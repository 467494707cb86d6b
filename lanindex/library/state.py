"""What is true of a library as a whole: which captures it has, and its change stamp."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from lanindex.errors import LibraryError
from lanindex.library.link import Link, among, ask, first_values

MOST = 500
"""Values in one statement: databases take a thousand at least."""


class State(NamedTuple):
    """The one row of ``state``."""

    id: int
    stamp: int
    captures: int
    numbers: int
    columns: int


def capture_numbers(connection: Link) -> list[int]:
    """Return the numbers of all captures, in order."""
    found: list[int] = first_values(ask(connection, "SELECT id FROM capture ORDER BY id"))
    check_numbers(connection, found)
    return found


def read_numbers(connection: Link, numbers: Sequence[int]) -> list[int]:
    """Return those numbers that captures have, in the order in which they are asked for."""
    found = set[int]()
    for first in range(0, len(numbers), MOST):
        chosen = among(numbers[first : first + MOST])
        found.update(first_values(ask(connection, f"SELECT id FROM capture WHERE id IN {chosen}")))
    return [number for number in numbers if number in found]


def check_numbers(connection: Link, found: Sequence[int]) -> None:
    """Refuse a library that has other captures than were stored."""
    stored, now = read_state(connection), (len(found), sum(found))
    if now != (stored.captures, stored.numbers):
        raise LibraryError(
            f"the library holds {now[0]} captures whose numbers add up to {now[1]}",
            wanted=f"{stored.captures} and {stored.numbers}, as were stored",
            remedy="Ingest the captures into a new library; or, if another program took some out "
            "on purpose, tell this one: UPDATE state SET "
            f"captures = {now[0]}, numbers = {now[1]}",
        )


def read_state(connection: Link) -> State:
    """Return the one row of ``state``."""
    found = ask(connection, f"SELECT {', '.join(State._fields)} FROM state").fetchall()
    if len(found) != 1 or not all(isinstance(value, int) for value in found[0]):
        raise LibraryError(
            f"the library's state is {found}",
            wanted="one row of whole numbers",
            remedy="Ingest the captures into a new library: all in it comes from them.",
        )
    return State(*found[0])
