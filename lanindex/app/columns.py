"""Columns on a terminal: how wide text is, cut in the middle where there is no room."""

from __future__ import annotations

import shutil
import unicodedata
from collections.abc import Iterator, Sequence

LEAST = 12
"""Cells that a column keeps, however narrow the terminal is."""

_GAP = "  "


def width(text: str) -> int:
    """Return how many cells of a terminal a text takes.

    Examples
    --------
    >>> width("walk"), width("歩く"), width("e\u0301")
    (4, 4, 1)
    """
    return len(text) if text.isascii() else sum(map(_cells, text))


def _cells(character: str) -> int:
    if unicodedata.category(character) in ("Mn", "Me", "Cf"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def cut(text: str, most: int) -> str:
    """Return a text that takes `most` cells at the most: its middle gives way.

    Examples
    --------
    >>> cut("archive/1998/walk.bvh", 13)
    'archiv…lk.bvh'
    """
    if width(text) <= most:
        return text
    room = most - 1
    tail = _first(text[::-1], room // 2)[::-1]
    while tail and not _cells(tail[0]):  # it belongs to what is cut
        tail = tail[1:]
    return f"{_first(text, room - room // 2)}…{tail}"


def _first(text: str, most: int) -> str:
    taken = 0
    for index, character in enumerate(text):
        taken += _cells(character)
        if taken > most:
            return text[:index]
    return text


def laid_out(lines: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield lines of cells as columns, numbers to the right, that fit the terminal.

    The widest columns give way first; none gets narrower than `LEAST`.
    """
    widths = _fitted([max(map(width, column)) for column in zip(*lines, strict=True)])
    for line in lines:
        cells = (_padded(cell, most) for cell, most in zip(line, widths, strict=True))
        yield _GAP.join(cells).rstrip()


def _fitted(widths: list[int]) -> list[int]:
    room = shutil.get_terminal_size().columns - len(_GAP) * (len(widths) - 1)
    while sum(widths) > room and max(widths) > LEAST:
        widest = widths.index(max(widths))
        others = sorted(widths)[-2] if len(widths) > 1 else LEAST
        least = max(LEAST, min(others, widths[widest] - 1))
        widths[widest] = max(least, widths[widest] - (sum(widths) - room))
    return widths


def _padded(cell: str, most: int) -> str:
    cell = cut(cell, most)
    space = " " * (most - width(cell))
    return space + cell if _numeric(cell) else cell + space


def _numeric(cell: str) -> bool:
    return cell.replace(".", "", 1).lstrip("-").isdigit()
