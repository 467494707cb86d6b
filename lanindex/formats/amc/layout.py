"""Where the frames of an AMC file lie."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.bvh.hierarchy import line_of, text_of
from lanindex.formats.file import PIECE, Content

_NUMBER = 64
"""Bytes that the number of a frame, and what surrounds it, is shorter than."""

_DIGITS = 15
_RATE = re.compile(rb"\s*:SAMPLES-PER-SECOND\s+([\d.]{1,12})\s*", re.IGNORECASE)

Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The bytes of an AMC file."""

    header: bytes  # what stands before the first frame
    starts: Places  # (T,) int64, where the number of each frame begins
    stops: Places  # (T,) int64, the byte behind it
    ends: Places  # (T,) int64, the byte behind each frame
    numbers: Places  # (T,) int64, the frames' own numbers

    @property
    def radians(self) -> bool | None:
        """Whether angles are said to be radians; None: nothing is said."""
        words = self.header.upper().split()
        return True if b":RADIANS" in words else False if b":DEGREES" in words else None

    @property
    def rate(self) -> Fraction | None:
        """Frames a second, where the header says."""
        for line in self.header.splitlines():
            said = _RATE.fullmatch(line)
            if said and said.group(1).count(b".") < 2 and said.group(1) != b".":
                return Fraction(said.group(1).decode()) or None
        return None


def scan(data: Content, path: str) -> Layout:
    """Find the frames of an AMC file without reading their numbers."""
    rows: list[tuple[int, int, int]] = []
    for start in range(0, len(data), PIECE):
        piece = data[start : start + PIECE + _NUMBER]
        for at in _numbered(piece, start == 0):
            line = piece[at : at + _NUMBER].partition(b"\n")[0]
            word = line.strip()
            if not word.isdigit() or len(word) > _DIGITS:
                raise CaptureError(
                    f"{text_of(line.strip())[:40]!r}",
                    place=f"{path}:{line_of(data, start + at)}",
                    wanted="the number of a frame alone on its line",
                )
            begin = start + at + len(line) - len(line.lstrip())
            rows.append((begin, begin + len(word), int(word)))
    if not rows:
        alone = b"\r" in data[:PIECE] and b"\n" not in data[:PIECE]
        remedy = "Its lines end in carriage returns alone: save it with line feeds." * alone
        wanted = "lines that are a frame's number"
        raise CaptureError("no frames", place=path, wanted=wanted, remedy=remedy)
    starts, stops, numbers = np.array(rows, np.int64).T
    ends = np.append(starts[1:], len(data))
    return Layout(data[: rows[0][0]], starts, stops, ends, numbers)


def _numbered(piece: bytes, first: bool) -> list[int]:
    """Return where the lines begin that begin with a digit, blanks aside."""
    text = np.frombuffer(piece, np.uint8)
    lines = np.flatnonzero(text[:PIECE] == 10) + 1
    if first:
        lines = np.append(0, lines)
    lines = lines[lines < len(text)]
    begun = text[lines]
    digit = (begun >= ord("0")) & (begun <= ord("9"))
    for index in np.flatnonzero((begun == ord(" ")) | (begun == ord("\t"))).tolist():
        at = int(lines[index])
        digit[index] = piece[at : at + _NUMBER].lstrip(b" \t")[:1].isdigit()
    places: list[int] = lines[digit].tolist()
    return places
