"""Scores drawn, read, performed and written down again: ``loop.py [NUMBER]``.

A score is drawn as `lanindex score` draws it, the picture is read as `lanindex read-score` reads
it, the score that was read is performed, and the motion is encoded. Of each kind of scores it
prints what share of the symbols is read rightly (part, direction, level, times to a quarter of a
count), what share is missed or false, and how many edits a symbol lead from what was read to what
its motion says, as in `laws.py`: of all gestures and steps. The last figure is the same for what
was drawn, without a picture between. NUMBER: how many scores there are of each kind, at most.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from importlib import import_module

import cv2
import numpy as np
from places import CAPTURES, changed
from reader import matched, wrong
from reader_pages import CORPUS, JUDGING, signs
from reader_scores import random_score

import lanindex
from lanindex.alphabet import KINDS, kind_of
from lanindex.draw.plain import plain
from lanindex.draw.staff import draw
from lanindex.draw.svg import FORMS, rendered
from lanindex.errors import LanindexError
from lanindex.model import Score, Span
from lanindex.model.derived import STEP
from lanindex.notation.excerpt import excerpt
from lanindex.reader.score import Read, read_signs, score_of

choreography = import_module("choreography").choreography
SECONDS = 8  # of each capture
PARTS = ("r_arm", "l_arm", "r_leg", "l_leg", "head", "torso")

Given = tuple[Score, bool]
"""A score, and whether it counts seconds."""


def corpus() -> Iterator[Given]:
    yield from ((lanindex.read_lnd(str(path)), False) for path in CORPUS)


def choreographies() -> Iterator[Given]:
    """Yield scores whose neighbouring directions are less than 60 degrees apart."""
    yield from ((choreography(seed, PARTS), True) for seed in range(JUDGING, JUDGING + 99))


def random() -> Iterator[Given]:
    for seed in range(JUDGING, JUDGING + 99):
        yield random_score(np.random.default_rng(seed), seconds=False), False


def captures() -> Iterator[Given]:
    """Yield a stretch of each of some captures, as a plain score."""
    for path in sorted((CAPTURES / "bvh").rglob("*.bvh"))[::10]:
        try:
            score = lanindex.encode(lanindex.read(path))
        except LanindexError as error:
            print(error, file=sys.stderr)
            continue
        first = max(score.frames - round(SECONDS * score.rate), 0) // 2
        yield plain(excerpt(score, Span(first, first + round(SECONDS * score.rate)))), True


def drawn_and_read(score: Score, *, seconds: bool) -> tuple[list, Read]:
    """Return the signs of a score on paper, and what is read there."""
    picture = draw(score, seconds=seconds)
    content = np.frombuffer(rendered(picture, "png", FORMS["png"][1]), np.uint8)
    page = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE)
    return signs(picture, score, seconds=seconds), read_signs(np.asarray(page, np.uint8))


def edits(score: Score) -> tuple[int, int]:
    """Return how many edits lead from a score to what its motion says, and its symbols."""
    last, wrong_ones, symbols = lanindex.encode(lanindex.animate(score)), 0, 0
    for part in score.tracks:
        if part != STEP and "level" in KINDS[kind_of(part)].fields:
            size = len(changed.shown(score, part))
            wrong_ones += changed.edits(score, last, part)[0] if part in last.tracks else size
            symbols += size
    return wrong_ones, symbols


@dataclass
class Figures:
    """What was counted on scores of a kind."""

    scores: int = 0
    refused: int = 0  # Pages on which no staff or no names are found
    signs: int = 0
    right: int = 0
    missed: int = 0
    false: int = 0
    edits: dict[str, tuple[int, int]] = field(default_factory=dict)  # And symbols

    def add(self, score: Score, *, seconds: bool) -> None:
        self.scores += 1
        try:
            truth, page = drawn_and_read(score, seconds=seconds)
        except LanindexError as error:
            print(error, file=sys.stderr)
            self.refused += 1
            return
        pairs = matched(truth, page.records)
        self.signs += len(truth)
        self.missed += sum(one is None for _, one in pairs)
        self.false += sum(sign is None for sign, _ in pairs)
        for sign, one in pairs:
            self.right += bool(sign and one and not {*wrong(sign, one)} - {"amount"})
        read = score_of([page], Fraction(60) if seconds else score.meter.speed)
        for name, one in (("read", read), ("drawn", score)):
            before = self.edits.get(name, (0, 0))
            self.edits[name] = tuple(map(sum, zip(before, edits(one), strict=True)))

    def row(self) -> str:
        shares = (it / max(self.signs, 1) for it in (self.right, self.missed, self.false))
        edits = (f"{a / max(b, 1):.3f} of {b}" for a, b in self.edits.values())
        counts = self.scores, self.refused, self.signs
        return " | ".join([*map(str, counts), *(f"{it:.3f}" for it in shares), *edits])


def main(words: list[str]) -> int:
    most = int(words[0]) if words else 30
    print("| scores | number | refused | symbols | right | missed | false | edits: read | drawn |")
    for given in (corpus, choreographies, random, captures):
        figures = Figures()
        for (score, seconds), _ in zip(given(), range(most), strict=False):
            figures.add(score, seconds=seconds)
        print(f"| {given.__name__} | {figures.row()} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
