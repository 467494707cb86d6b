"""Judge what reads printed scores: ``reader.py [--pages N] [--show FOLDER] [LEVEL ...]``.

Each page is drawn from a score and damaged as scanners and cameras do it, so every sign on it is
known (`reader_pages.py`). A sign is right if its part, direction, level, beginning and end are, the
times to a quarter of a count. The amount of those that have one (degrees of a turn, how far a limb
is bent) is a figure of its own.
"""

import sys
from argparse import ArgumentParser
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from math import nan
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from reader_damage import LEVELS
from reader_pages import GRID, JUDGING, Made, Sign, made

from lanindex.errors import LanindexError

Reader = Callable[[NDArray[np.uint8]], Sequence[Any]]
"""What reads a page: its records have part, direction, level, start and end, some an amount."""
Pair = tuple[Sign | None, Any | None]


_UNWRITTEN = {"jump": "direction", "stance": "level"}
"""What is not on paper, but follows from the signs before and after."""


def wrong(truth: Sign, read: Any) -> list[str]:
    """Return in what a sign that was read differs from the one on the page."""
    close = 0.5 / GRID + 1e-6  # eighths may be rounded either way
    written = {"direction", "level"} - {_UNWRITTEN.get(truth.kind)}
    found = [name for name in sorted(written) if getattr(read, name) != getattr(truth, name)]
    if max(abs(read.start - truth.start), abs(read.end - truth.end)) > close:
        found.append("times")
    if truth.amount is not None and getattr(read, "amount", None) != truth.amount:
        found.append("amount")
    return found


def matched(truth: Sequence[Sign], read: Sequence[Any]) -> list[Pair]:
    """Return pairs of a sign and what it was read as, those that share most of their time first.

    None: a sign that was not read, or one that is not there.
    """
    shares = []
    by_part = defaultdict(list)
    for there, one in enumerate(read):
        by_part[one.part].append((there, one))
    for here, sign in enumerate(truth):
        for there, one in by_part[sign.part]:
            share = _shared(sign.start, sign.end, one.start, one.end)
            if share > 0 and (sign.start == sign.end) == (one.start == one.end):
                shares.append((-share, len(wrong(sign, one)), here, there))
    pairs = dict[int, int]()
    taken = set[int]()
    for *_, here, there in sorted(shares):
        if here not in pairs and there not in taken:
            pairs[here] = there
            taken.add(there)
    found = [(it, read[pairs[at]] if at in pairs else None) for at, it in enumerate(truth)]
    return [*found, *((None, it) for at, it in enumerate(read) if at not in taken)]


def _shared(start: float, end: float, other: float, until: float) -> float:
    """Return the time that two signs share, of that of both; one without length has a quarter."""
    half = 0.5 / GRID
    if start == end:
        start, end = start - half, end + half
    if other == until:
        other, until = other - half, until + half
    return (min(end, until) - max(start, other)) / (max(end, until) - min(start, other))


@dataclass(slots=True)
class Figures:
    """What was counted on pages."""

    pages: int = 0
    refused: int = 0  # Pages
    signs: int = 0
    false: int = 0
    amounts: int = 0  # Signs that have one
    seconds: float = 0.0  # Of the processor
    # How many signs are right by what, and in direction, level and times together
    right: Counter[str] = field(default_factory=Counter)

    def add(self, page: Made, read: Reader) -> list[Pair]:
        """Count what is read of a page, and return all pairs."""
        began = process_time()
        try:
            records = read(page.image)
        except LanindexError:
            records, self.refused = [], self.refused + 1
        self.seconds += process_time() - began
        self.pages += 1
        self.signs += len(page.truth)
        self.amounts += sum(sign.amount is not None for sign in page.truth)
        pairs = matched(page.truth, records)
        for sign, one in pairs:
            self.false += sign is None
            if sign and one:
                faults = {*wrong(sign, one)}
                self.right["sign"] += not faults - {"amount"}
                self.right["amount"] += sign.amount is not None and "amount" not in faults
                self.right.update({"direction", "level", "times"} - faults)
        return pairs

    def row(self) -> list[str]:
        """Return the figures in order; what was not read is wrong in everything."""
        signs, amounts = self.signs or nan, self.amounts or nan
        shares = [self.right[it] / signs for it in ("sign", "direction", "level", "times")]
        shares += [self.right["amount"] / amounts, self.false / signs]
        each = self.seconds / max(self.pages, 1)
        counts = [str(it) for it in (self.pages, self.refused, self.signs)]
        return [*counts, *(f"{it:.4f}" for it in shares), f"{each:.2f}"]


HEAD = (
    *("damage", "pages", "refused", "signs", "right", "direction", "level", "times"),
    *("amount", "false", "s/page"),
)
MISSED, CHANGED, FALSE = (0, 0, 220), (0, 120, 255), (220, 0, 200)
"""Colours, blue first: what was not read, what was read wrongly, what is not there."""


def show(page: Made, pairs: Sequence[Pair], path: Path) -> None:
    """Write a page with what is wrong marked, and what it was read as."""
    import cv2

    image = cv2.cvtColor(page.image, cv2.COLOR_GRAY2BGR)
    for sign, one in pairs:
        faults = wrong(sign, one) if sign and one else ["missed" if sign else "false"]
        if not faults:
            continue
        color = (CHANGED if one else MISSED) if sign else FALSE
        at = sign or one
        told = f"{one.direction or ''} {one.level or ''} {one.start:g}-{one.end:g}" if one else ""
        for box in page.boxes(at.part, at.start, at.end):
            corners = box.round().astype(np.int32)
            cv2.polylines(image, [corners], isClosed=True, color=color, thickness=2)
            where = tuple(corners[3].tolist())
            words = f"{at.part} {'+'.join(faults)}: {told}" if one else "missed"
            cv2.putText(image, words, where, cv2.FONT_HERSHEY_SIMPLEX, 0.35, color, 1, cv2.LINE_AA)
    cv2.imwrite(str(path), image)


def main(words: list[str]) -> int:
    """Print the figures of each level of damage."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("levels", nargs="*", metavar="LEVEL", help=", ".join(LEVELS))
    parser.add_argument("--pages", type=int, default=40, help="pages of each level")
    parser.add_argument("--first", type=int, default=JUDGING, help="the first page's seed")
    parser.add_argument("--show", type=Path, help="where to write pages with what is wrong")
    options = parser.parse_args(words)
    if unknown := {*options.levels} - {*LEVELS}:
        parser.error(f"{', '.join(sorted(unknown))}: a level is one of {', '.join(LEVELS)}")
    read: Reader = import_module("lanindex.reader.score").read_page
    if options.show:
        options.show.mkdir(parents=True, exist_ok=True)
    print(" ".join(f"{it:>9}" for it in HEAD))
    for level in options.levels or LEVELS:
        figures = Figures()
        for seed in range(options.first, options.first + options.pages):
            page = made(seed, level)
            pairs = figures.add(page, read)
            if options.show and any(not a or not b or wrong(a, b) for a, b in pairs):
                show(page, pairs, options.show / f"{level}-{seed}.png")
        print(" ".join(f"{it:>9}" for it in (level, *figures.row())), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
