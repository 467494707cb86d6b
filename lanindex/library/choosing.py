"""A library that tells which captures are meant, and what they are called, by its columns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice
from typing import Any, NoReturn

from lanindex.errors import LibraryError
from lanindex.library import read
from lanindex.library.called import Called
from lanindex.library.find import Where, fitting, globs, needed
from lanindex.library.keeper import Keeper
from lanindex.library.link import Link
from lanindex.library.segments import Distrust
from lanindex.model import Capture


class Choosing(Keeper):
    """An open library of which some captures are chosen."""

    def __init__(self, *where: Any, **how: Any) -> None:
        super().__init__(*where, **how)
        self._texts = Called()

    def numbers(self, within: str | None = None, where: Where | None = None) -> list[int]:
        """Return the numbers of the captures that are meant, without reading each of them.

        Parameters
        ----------
        within, where
            As for `captures`.

        Raises
        ------
        UsageError
            If no capture has such a column.
        LibraryError
            If a capture that is in no segment is not what was stored.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.numbers("*conductor*"), library.numbers(where={"label": "march*"})
        ([2, 3], [6])
        """
        asked = globs(within, where)
        numbers, called = self._called(*needed(asked))
        return [numbers[place] for place in fitting(called, range(len(numbers)), asked)]

    def called(self, name: str, numbers: Iterable[int] | None = None) -> dict[int, Any]:
        """Return what captures are called, by their numbers, without reading each of them.

        Parameters
        ----------
        name : str
            ``path``, ``location``, ``format``, ``label``, ``metadata`` or ``profile``.
        numbers : iterable of int, optional
            Of which captures; else of all.

        Raises
        ------
        LibraryError
            If there is none of such a number.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.called("label", [6])
        {6: 'marching'}
        """
        every, texts = self._called(name)
        found = dict(zip(every, texts[name], strict=True))
        if numbers is None:
            return found
        return {one: found[one] if one in found else _none(one, self.place) for one in numbers}

    def begun(self, text: str, most: int) -> list[str]:
        """Return so many paths that begin with a text, or whose file's name does, in order.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     library.begun("conductor_t", 5)
        ['corpus/conductor_three.bvh']
        """
        with self._reading() as connection:
            return list(islice(read.paths_begun(connection, text), most))

    def some(self, numbers: Sequence[int]) -> list[Capture]:
        """Return those captures that exist of some, in the order of their numbers.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     [capture.label for capture in library.some([6, 2, 1000])]
        ['conducting', 'marching']
        """
        with self._reading() as connection:
            return read.read_chosen(connection, sorted(set(numbers)))

    def _called(self, *names: str) -> tuple[list[int], dict[str, Sequence[Any]]]:
        """Return the numbers of all captures and what they are called, by name of the column.

        Where the segments cannot be trusted that comes from the rows, and they are mended when
        columns are asked for.
        """
        try:
            with self._reading() as connection:
                return self._texts.find(connection, names)
        except Distrust as fault:
            self._doubt = fault.found
        with self._reading() as connection:
            return self._texts.find(connection, names, trusted=False)

    def _places(self, connection: Link) -> dict[str, Sequence[Any]]:
        """Return where all captures are, inside a transaction."""
        names = ("path", "location")
        try:
            return self._texts.find(connection, names)[1]
        except Distrust as fault:
            self._doubt = fault.found
            return self._texts.find(connection, names, trusted=False)[1]


def _none(number: int, place: str) -> NoReturn:
    raise LibraryError(
        f"there is no capture {number} any more",
        place=place,
        remedy="Search again: the library has changed since.",
    )
