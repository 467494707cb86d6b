"""The hits of a search as columns, made objects one by one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol, overload

import numpy as np

from lanindex.model import Capture, Hit, Span
from lanindex.model.columns import THOUSANDTHS
from lanindex.search.fast.answers import Answers
from lanindex.search.fast.ragged import Numbers, Whole, starts_of

TOGETHER = 64
"""How many captures are fetched at once where all hits are made objects."""


class Maker(Protocol):
    """What makes hits of answers."""

    def hit(self, answer: Answers) -> Hit:
        """Return the one answer of a table as an object."""

    def fetch(self, places: Sequence[int]) -> None:
        """Fetch captures, by their places in the roster, of which hits will be made objects."""

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""

    def numbers(self, places: Whole) -> Whole:
        """Return the numbers of captures by their places in the roster."""


class Found(Sequence[Hit]):
    """The hits of a search as columns; each is made an object when it is asked for.

    Parameters
    ----------
    maker : Maker
        Makes them.
    answers : Answers
        All answers in order of capture, start, end, and fit where it is known.
    chosen : ndarray
        (H,) int64: which of them are the hits. Of those with the same frames it tells the first,
        second … clearest.
    left : int
        In how many captures the engine left the search to the plain matcher.

    Attributes
    ----------
    place : ndarray
        (H,) int64: which capture of the roster.
    low, high : ndarray
        (H,) int64: frames of the source, half-open.
    """

    def __init__(self, maker: Maker, answers: Answers, chosen: Whole, left: int) -> None:
        self.left = left
        self._maker, self._answers, self._chosen = maker, answers, chosen
        self.place, self.low, self.high = (
            column[chosen] for column in (answers.capture, answers.low, answers.high)
        )
        new = starts_of(answers.capture) | starts_of(answers.low) | starts_of(answers.high)
        self._alike = np.append(np.flatnonzero(new), len(answers))
        self._told: tuple[int, list[Hit]] = -1, []

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._chosen)

    @overload
    def __getitem__(self, index: int) -> Hit: ...
    @overload
    def __getitem__(self, index: slice) -> Found: ...
    def __getitem__(self, index: int | slice) -> Hit | Found:
        """Return one hit, or some of them."""
        if isinstance(index, slice):
            return Found(self._maker, self._answers, self._chosen[index], self.left)
        place = int(self._chosen[range(len(self))[index]])
        first, last = self._those_alike(place)
        if last - first == 1 or (self._answers.cost[first:last] >= 0).all():
            return self._maker.hit(self._answers.at(np.array([place])))
        if self._told[0] != first:
            hits = [self._maker.hit(self._answers.at(np.array([it]))) for it in range(first, last)]
            self._told = first, sorted(hits, key=lambda hit: -hit.fit)
        return self._told[1][place - first]

    def _those_alike(self, place: int) -> tuple[int, int]:
        """Return from where to where answers have the frames of one of them."""
        group = int(np.searchsorted(self._alike, place, "right"))
        return int(self._alike[group - 1]), int(self._alike[group])

    def __iter__(self) -> Iterator[Hit]:
        """Yield all hits, in whatever order they stand; captures are fetched many at once."""
        first, places = 0, set[int]()
        for index, place in enumerate([*self.place.tolist(), -1]):
            if place < 0 or (len(places) == TOGETHER and place not in places):
                self._maker.fetch(sorted(places))
                yield from (self[one] for one in range(first, index))
                first, places = index, set()
            places.add(place)

    def _fits(self) -> Numbers:
        """Return how clear each hit is, (H,) in thousandths; those not known are made for it."""
        fits = THOUSANDTHS - self._answers.cost[self._chosen]
        for index in np.flatnonzero(fits > THOUSANDTHS).tolist():
            fits[index] = round(self[index].fit * THOUSANDTHS)
        return fits

    def by_fit(self) -> Found:
        """Return the same hits, the clearest first."""
        order = np.argsort(-self._fits(), kind="stable")
        return Found(self._maker, self._answers, self._chosen[order], self.left)

    @property
    def captures(self) -> int:
        """In how many captures they are."""
        return len(_distinct(self.place)[0])

    def tally(self) -> list[tuple[int, int]]:
        """Return the numbers of the captures, each with how many hits it has."""
        places, counts = _distinct(self.place)
        return list(zip(self._maker.numbers(places).tolist(), counts.tolist(), strict=True))

    def counts(self) -> list[tuple[Capture, int]]:
        """Return the captures, each with how many hits it has."""
        places, counts = np.unique(self.place, return_counts=True)
        return list(zip(self._maker.captures(places.tolist()), counts.tolist(), strict=True))

    def spans(self) -> Iterator[tuple[Capture, Span]]:
        """Yield capture and frames of each hit."""
        places = np.unique(self.place).tolist()
        captures = dict(zip(places, self._maker.captures(places), strict=True))
        for place, low, high in zip(
            self.place.tolist(), self.low.tolist(), self.high.tolist(), strict=True
        ):
            yield captures[place], Span(low, high)

    def arranged(self, order: Sequence[int]) -> Found:
        """Return the same hits in another order."""
        return Found(self._maker, self._answers, self._chosen[np.array(order, np.int64)], self.left)

    def numpy(self) -> Numbers:
        """Return the hits as an array, as `lanindex.search.hits.Hits.numpy`."""
        fields = [("capture_id", "i8"), ("start", "i8"), ("stop", "i8"), ("fit", "f4")]
        found = np.empty(len(self), fields)
        found["capture_id"] = self._maker.numbers(self.place)
        found["start"], found["stop"] = self.low, self.high
        found["fit"] = self._fits() / THOUSANDTHS
        return found


def _distinct(place: Whole) -> tuple[Whole, Whole]:
    """Return the captures of hits, in order, and how many each has.

    What numpy has for this imports as much as all of a small search takes.
    """
    ordered = np.sort(place)
    firsts = np.flatnonzero(starts_of(ordered))
    return ordered[firsts], np.diff(firsts, append=len(ordered))
