"""A printed score as a notation that is only read: its pages, and the score that they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from lanindex.errors import CaptureError, extra
from lanindex.reader.page import pages

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from lanindex.model import Score
    from lanindex.reader.score import Read, Record

SPEED = Fraction(60)
"""Beats a minute, if nobody says how many."""


@dataclass(frozen=True, slots=True, eq=False)
class Printed:
    """A printed score: its pages, and what was read on them."""

    path: str
    images: list[NDArray[np.uint8]]  # (H, W) grey
    read: dict[int, Read]  # By number of page, from 1 on; a page without a staff is not in it

    def score(self, speed: Fraction = SPEED) -> Score:
        """Return the score, at so many beats a minute; its warnings are what there is to say."""
        from lanindex.reader.score import score_of

        try:
            score = score_of([*self.read.values()], speed)
        except CaptureError as error:
            error.place = self.path
            raise
        return replace(score, warnings=tuple(self.notes()))

    def unsure(self) -> Iterator[tuple[int, Record, str]]:
        """Yield signs that are not known or doubtful: page, sign, and what is said of it."""
        from lanindex.reader.score import DOUBTFUL

        for number, page in self.read.items():
            doubtful = [it for it in page.records if it.confidence < DOUBTFUL]
            for sign in sorted((*page.unknown, *doubtful), key=lambda it: (it.staff, it.start)):
                told = f"{' '.join(map(str, sign.words))}, {sign.confidence:.0%} sure"
                yield number, sign, told if sign.kind else "not known, left out"

    def about_pages(self) -> Iterator[str]:
        """Yield which pages have no staff, and what of others is not known but no sign."""
        for number in range(1, len(self.images) + 1):
            if number not in self.read:
                yield f"page {number}: no staff of Labanotation, left out"
            else:
                yield from (f"page {number}: {it}" for it in self.read[number].notes)

    def notes(self) -> Iterator[str]:
        """Yield the same, and which signs are not known or doubtful."""
        yield from self.about_pages()
        for number, sign, told in self.unsure():
            yield f"page {number}, {sign.place}: {told}"


def open_printed(
    path: str, content: bytes | None = None, watch: Callable[[int, int], None] | None = None
) -> Printed:
    """Read a picture or a PDF of a printed score.

    Parameters
    ----------
    path : str
        The file.
    content : bytes, optional
        What is in it, where it is at hand.
    watch : callable, optional
        Is told how many pages are done, of how many.

    Returns
    -------
    Printed

    Raises
    ------
    CaptureError
        If it cannot be read, or no page of it has a staff.
    """
    images = pages(path, content)
    with extra("reader", path, CaptureError):
        from lanindex.reader.score import read_signs
    read: dict[int, Read] = {}
    for number, image in enumerate(images, 1):
        if watch:
            watch(number - 1, len(images))
        try:
            read[number] = read_signs(image)
        except CaptureError as error:
            if number == len(images) and not read:
                error.place = path
                raise
    return Printed(path, images, read)


def read(content: bytes, *, place: str) -> Score:
    """Return the score in a picture or a PDF."""
    return open_printed(place, content).score()
