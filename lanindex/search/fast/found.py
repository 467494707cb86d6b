"""The hits of a search as columns, made objects one by one."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Hit
from lanindex.model.columns import THOUSANDTHS
from lanindex.search.fast.answers import Answers
from lanindex.search.fast.placed import TOGETHER, Holder, Placed
from lanindex.search.fast.ragged import Numbers, Whole, starts_of


class Maker(Holder, Protocol):
    """What makes hits of answers."""

    def hits(self, answers: Answers) -> list[Hit]:
        """Return the answers of a table as objects."""


class Found(Placed):
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
    """

    def __init__(self, maker: Maker, answers: Answers, chosen: Whole) -> None:
        frames = (column[chosen] for column in (answers.capture, answers.low, answers.high))
        super().__init__(maker, *frames)
        self._maker, self._answers, self._chosen = maker, answers, chosen

    @cached_property
    def _alike(self) -> Whole:
        """Where answers with the same frames begin, and how many there are."""
        answers = self._answers
        new = starts_of(answers.capture) | starts_of(answers.low) | starts_of(answers.high)
        return np.append(np.flatnonzero(new), len(answers))

    def _some(self, chosen: Numbers | slice) -> Found:
        return Found(self._maker, self._answers, self._chosen[chosen])

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        places = self._chosen[list(indices)].tolist()
        alike = {place: self._those_alike(place) for place in places}
        # only the fit tells which of those with the same frames is the clearest
        unclear = {
            (first, last)
            for first, last in alike.values()
            if last - first > 1 and (self._answers.cost[first:last] < 0).any()
        }
        wanted = sorted({*places, *(it for ends in unclear for it in range(*ends))})
        made = dict(zip(wanted, self._maker.hits(self._answers.at(np.array(wanted))), strict=True))
        for first, last in unclear:
            hits = sorted((made[it] for it in range(first, last)), key=lambda hit: -hit.fit)
            made.update(zip(range(first, last), hits, strict=True))
        return [made[place] for place in places]

    def _those_alike(self, place: int) -> tuple[int, int]:
        """Return from where to where answers have the frames of one of them."""
        group = int(np.searchsorted(self._alike, place, "right"))
        return int(self._alike[group - 1]), int(self._alike[group])

    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is; those of which it is not known are made for it."""
        cost = self._answers.cost[self._chosen]
        fits = THOUSANDTHS - cost
        unknown = np.flatnonzero(cost < 0)
        fits[unknown] = [round(hit.fit * THOUSANDTHS) for hit in self._some(unknown)]
        clear: NDArray[np.float64] = fits / THOUSANDTHS
        return clear

    def by_fit(self, most: int | None = None) -> Found:
        """Return the same hits, the clearest first; as `Placed.by_fit`.

        Where only some will be looked at, no more are made than may be among those.
        """
        if most is None or most >= len(self):
            return super().by_fit()
        clearest = self.clearest(most)
        rest = np.ones(len(self), np.bool_)
        rest[clearest] = False
        return self._some(np.append(clearest, np.flatnonzero(rest)))

    def clearest(self, most: int) -> Whole:
        """Return the places of so many hits, the clearest first, of these that which stands first.

        Those that might be are made, the likely ones first.
        """
        least = self._least_missing()
        likely = np.argsort(least, kind="stable")
        found, missing = np.empty((2, 0), np.int64)
        for first in range(0, len(likely), TOGETHER):
            if len(found) == most:
                following = int(likely[first])
                if (missing[-1], found[-1]) < (least[following], following):
                    break
            some = np.sort(likely[first : first + TOGETHER])
            found = np.append(found, some)
            clear = self._some(some).clear()
            missing = np.append(missing, np.rint(THOUSANDTHS * (1 - clear)).astype(np.int64))
            order = np.lexsort((found, missing))[:most]
            found, missing = found[order], missing[order]
        return found

    def _least_missing(self) -> Whole:
        """Return what is missing at least to a fit of 1, of the clearest with the same frames."""
        cost = self._answers.cost
        least = np.where(cost < 0, ~cost, cost)
        if len(least):
            least = np.minimum.reduceat(least, self._alike[:-1])
        found: Whole = least[np.searchsorted(self._alike, self._chosen, "right") - 1]
        return found
