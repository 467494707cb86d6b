"""Hits as columns: capture and frames are known, each is made an object when it is asked for."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any, Protocol, Self, overload

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Capture, Hit, Span

IntArray = NDArray[np.int64]

TOGETHER = 512  # captures fetched at once where all hits are made objects


class Holder(Protocol):
    """Holds the captures of hits, by their places in the roster."""

    def fetch(self, places: Sequence[int]) -> None:
        """Fetch captures of which hits will be made objects."""

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures."""

    def numbers(self, places: IntArray) -> IntArray:
        """Return the numbers of captures."""


class Placed(Sequence[Hit]):
    """Hits of which capture and frames are known; each is made an object when it is asked for.

    Parameters
    ----------
    holder : Holder
        Fetches captures, and gives them and their numbers, by places in the roster.
    place : ndarray
        (H,) int64: which capture of the roster.
    low, high : ndarray
        (H,) int64: frames of the source, half-open.
    """

    def __init__(self, holder: Holder, place: IntArray, low: IntArray, high: IntArray) -> None:
        self._holder, self.place, self.low, self.high = holder, place, low, high

    @abstractmethod
    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        """Return some hits as objects."""

    @abstractmethod
    def _some(self, chosen: NDArray[Any] | slice) -> Self:
        """Return some of them, in whatever order."""

    @abstractmethod
    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is, (H,) from 0 to 1."""

    def __len__(self) -> int:
        return len(self.place)

    @overload
    def __getitem__(self, index: int) -> Hit: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    def __getitem__(self, index: int | slice) -> Hit | Self:
        """Return one hit, or some of them."""
        if isinstance(index, slice):
            return self._some(index)
        return self._hits([range(len(self))[index]])[0]

    def __iter__(self) -> Iterator[Hit]:
        """Yield all hits, in whatever order they stand; captures are fetched many at once."""
        first, places = 0, set[int]()
        for index, place in enumerate([*self.place.tolist(), -1] if len(self) else []):
            if place < 0 or (len(places) == TOGETHER and place not in places):
                self._holder.fetch(sorted(places))
                yield from self._hits(range(first, index))
                first, places = index, set()
            places.add(place)

    @property
    def captures(self) -> int:
        """In how many captures they are."""
        return len(self._counted()[0])

    def tally(self) -> list[tuple[int, int]]:
        """Return the numbers of the captures, each with how many hits it has."""
        places, counts = self._counted()
        return list(zip(self._holder.numbers(places).tolist(), counts.tolist(), strict=True))

    def counts(self) -> list[tuple[Capture, int]]:
        """Return the captures, each with how many hits it has."""
        places, counts = self._counted()
        return list(zip(self._holder.captures(places.tolist()), counts.tolist(), strict=True))

    def spans(self) -> Iterator[tuple[Capture, Span]]:
        """Yield capture and frames of each hit."""
        places = self._counted()[0].tolist()
        captures = dict(zip(places, self._holder.captures(places), strict=True))
        columns = (self.place.tolist(), self.low.tolist(), self.high.tolist())
        for place, low, high in zip(*columns, strict=True):
            yield captures[place], Span(low, high)

    def arranged(self, order: Sequence[int]) -> Self:
        """Return the same hits in another order."""
        return self._some(np.array(order, np.int64))

    def by_fit(self, most: int | None = None) -> Self:
        """Return the same hits, the clearest first.

        Parameters
        ----------
        most : int, optional
            So many will be looked at; the order of the others may be any.
        """
        return self._some(np.argsort(-self.clear(), kind="stable"))

    def numpy(self) -> NDArray[Any]:
        """Return the hits as an array, as `lanindex.search.hits.Hits.numpy`."""
        fields = [("capture_id", "i8"), ("start", "i8"), ("stop", "i8"), ("fit", "f4")]
        found = np.empty(len(self), fields)
        found["capture_id"] = self._holder.numbers(self.place)
        found["start"], found["stop"], found["fit"] = self.low, self.high, self.clear()
        return found

    def _counted(self) -> tuple[IntArray, IntArray]:
        """Return the captures of hits, in order, and how many each has.

        What numpy has for this imports as much as all of a small search takes.
        """
        ordered = np.sort(self.place)
        firsts = np.flatnonzero(np.diff(ordered, prepend=-1))
        return ordered[firsts], np.diff(firsts, append=len(ordered))
