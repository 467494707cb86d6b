"""Columns that fit a terminal: long text is cut in the middle."""

from __future__ import annotations

import shutil
import unicodedata
from collections.abc import Iterable, Iterator, Sequence

LEAST = 12
"""Least cells of a column of words, however narrow the terminal is."""


def width(text: str) -> int:
    """Return how many cells of a terminal a text takes: wide characters take two.

    Examples
    --------
    >>> from lanindex.app.columns import width
    >>> width("walk"), width("歩く"), width("e\u0301")
    (4, 4, 1)
    """
    return len(text) if text.isascii() else sum(map(_cells, text))


def _cells(character: str) -> int:
    if unicodedata.category(character) in ("Mn", "Me", "Cf"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` cells, with ``…`` for its middle if it is longer.

    Examples
    --------
    >>> from lanindex.app.columns import cut
    >>> cut("archive/1998/walk.bvh", 13)
    'archiv…lk.bvh'
    """
    if width(text) <= most:
        return text
    room = most - 1
    tail = _first(text[::-1], room // 2)[::-1]
    while tail and not _cells(tail[0]):  # a mark on a character that is cut
        tail = tail[1:]
    return f"{_first(text, room - room // 2)}…{tail}"


def _first(text: str, most: int) -> str:
    taken = 0
    for index, character in enumerate(text):
        taken += _cells(character)
        if taken > most:
            return text[:index]
    return text


def wrapped(pieces: Iterable[str], most: int) -> list[str]:
    """Return pieces joined by commas, on lines of at most `most` cells if possible.

    Examples
    --------
    >>> from lanindex.app.columns import wrapped
    >>> wrapped(["r_arm high", "mid", "low"], 16)
    ['r_arm high, mid,', 'low']
    """
    lines = [""]
    for piece in pieces:
        longer = f"{lines[-1]}, {piece}" if lines[-1] else piece
        if lines[-1] and width(longer) >= most:  # a comma may follow
            lines[-1] += ","
            lines.append(piece)
        else:
            lines[-1] = longer
    return lines


def aligned(lines: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield lines of cells, the head first, as columns that fit the terminal.

    Numbers are aligned to the right and never cut. The widest columns of words shrink first, none
    below `LEAST`; if that is not enough, the gaps between columns do.
    """
    widths = _fitted(list(zip(*lines, strict=True)))
    gap = "  " if sum(widths) + 2 * (len(widths) - 1) <= room() else " "
    for line in lines:
        cells = (_padded(cell, most) for cell, most in zip(line, widths, strict=True))
        yield gap.join(cells).rstrip()


def _fitted(columns: Sequence[Sequence[str]]) -> list[int]:
    widths = [max(map(width, column)) for column in columns]
    words = [at for at, column in enumerate(columns) if any(map(_worded, column[1:]))]
    over = sum(widths) + 2 * (len(widths) - 1) - room()
    while over > 0 and (wide := [at for at in words if widths[at] > LEAST]):
        widest, *others = sorted(wide, key=lambda at: -widths[at])
        least = max([LEAST, *(widths[at] for at in others[:1])])
        less = max(1, min(over, widths[widest] - least))
        widths[widest] -= less
        over -= less
    return widths


def room() -> int:
    """Return how many cells a line of the terminal has."""
    return shutil.get_terminal_size().columns


def _worded(cell: str) -> bool:
    return any(map(str.isalpha, cell))


def _padded(cell: str, most: int) -> str:
    cell = cut(cell, most)
    space = " " * (most - width(cell))
    return space + cell if _numeric(cell) else cell + space


def _numeric(cell: str) -> bool:
    return cell.replace(".", "", 1).lstrip("-").isdigit()
