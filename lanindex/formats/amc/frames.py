"""The frames of an AMC file: where they lie, their numbers, and clips of them.

Where all frames name the bones in one order, the names are blanked out and the numbers are read
as BVH's are; else line by line, which also says what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.amc.asf import Bone
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import PIECE, Content, File, clip, line_of, text_of
from lanindex.formats.tables import fault, number_rows
from lanindex.model import Reading, Span

_NUMBER = 64
"""Bytes that the number of a frame, and what surrounds it, is shorter than."""

_DIGITS = 15
_RATE = re.compile(rb"\s*:SAMPLES-PER-SECOND\s+([\d.]{1,12})\s*", re.IGNORECASE)

Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class AmcLayout:
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


def scan(data: Content, path: str) -> AmcLayout:
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
    return AmcLayout(data[: rows[0][0]], starts, stops, ends, numbers)


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


Floats = NDArray[np.float64]


class Numbers:
    """Reads the numbers of frames."""

    def __init__(self, bones: Sequence[Bone]) -> None:
        self._stiff = {bone.name for bone in bones if not bone.dof}
        self.columns: dict[bytes, slice] = {}
        self.width = 0
        for bone in bones:
            if bone.dof:
                self.columns[bone.name] = slice(self.width, self.width + len(bone.dof))
                self.width += len(bone.dof)

    def read(self, data: bytes, stops: Places, ends: Places, place: Callable[[int], str]) -> Floats:
        """Read some frames.

        Takes `stops, ends` (T,); returns (T, W).
        """
        values = self._alike(data, stops, ends)
        return self._each(data, stops, ends, place) if values is None else values

    def _alike(self, data: bytes, stops: Places, ends: Places) -> Floats | None:
        """Read frames that are all written alike; None: they are not, or something is wrong."""
        first, last = int(stops[0]), int(ends[-1])
        begun = [line.split() for line in data[first : int(ends[0])].split(b"\n")[1:]]
        names = [words[0] for words in begun if words]
        if not names or len(names) != len(self.columns) or set(names) != self.columns.keys():
            return None
        text = np.frombuffer(data, np.uint8)[first:last].copy()
        breaks = np.flatnonzero(text == ord("\n")) + 1
        if text[-1] != ord("\n"):
            breaks = np.append(breaks, len(text))
        if len(breaks) != len(stops) * (len(names) + 1):
            return None
        lines = breaks.reshape(len(stops), -1)  # of a frame: its bones, and the next frame
        if (lines[:, -1] != ends - first).any():
            return None
        blank = text <= ord(" ")
        words = np.flatnonzero(blank[:-1] & ~blank[1:]) + 1
        counts = np.diff(np.searchsorted(words, lines), axis=1) - 1
        widths = [self.columns[name].stop - self.columns[name].start for name in names]
        if (counts != widths).any():
            return None
        for index, name in enumerate(names):
            cells = lines[:, [index]] + np.arange(len(name))
            if (text[cells] != np.frombuffer(name, np.uint8)).any():
                return None
            text[cells] = ord(" ")
        numbers, bad = number_rows(text.tobytes(), lines[:, [0, -1]], self.width)
        order = np.concatenate([np.arange(self.width)[self.columns[name]] for name in names])
        values = np.empty_like(numbers)
        values[:, order] = numbers
        return values if bad is None else None

    def _each(
        self, data: bytes, stops: Places, ends: Places, place: Callable[[int], str]
    ) -> Floats:
        """Read line by line."""
        values = np.full((len(stops), self.width), np.nan)
        for row, at, end in zip(values, stops.tolist(), ends.tolist(), strict=True):
            left = set(self.columns)
            begin = at
            for line in data[at:end].split(b"\n"):
                words = line.split()
                if words and not words[0].startswith(b"#"):
                    self._bone(row, words, left, partial(place, begin))
                begin += len(line) + 1
            if left:
                missing = next(name for name in self.columns if name in left)
                raise CaptureError(
                    f"the frame lacks {text_of(missing)}",
                    place=place(at),
                    wanted=f"{len(self.columns)} bones, as its skeleton declares",
                )
        return values

    def _bone(
        self, row: Floats, words: list[bytes], left: set[bytes], place: Callable[[], str]
    ) -> None:
        """Read the line of a bone."""
        name, count = words[0], len(words) - 1
        if name in self._stiff and not count:
            return
        shown = text_of(name)[:40]
        if name not in left:
            again = name in self.columns or name in self._stiff
            found = f"a second {shown}" if again else f"the bone {shown!r}"
            raise CaptureError(found, place=place(), wanted="each bone of its skeleton once")
        columns = self.columns[name]
        width = columns.stop - columns.start
        try:
            numbers = [float(word) for word in words[1:] if b"_" not in word]
        except ValueError:
            numbers = []
        if len(numbers) != count or count != width or not all(abs(it) <= LARGEST for it in numbers):
            found, wanted = fault(b" ".join(words[1:]), width)
            raise CaptureError(f"{shown} {found}", place=place(), wanted=wanted)
        row[columns] = numbers
        left.discard(name)


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of an AMC file, which is looked through once.

    The header and the lines of the frames are the source's; frames count from 1. The skeleton is
    no part of a clip: `beside` gives it.
    """
    layout = scan(file.content, file.name)

    def pieces(span: Span) -> Iterator[bytes | tuple[int, int]]:
        yield layout.header
        frames = slice(span.start, span.stop)
        stops, ends = layout.stops[frames].tolist(), layout.ends[frames].tolist()
        for number, frame in enumerate(zip(stops, ends, strict=True), 1):
            yield b"%d" % number
            yield frame

    return lambda span: clip(file.content, pieces(span))
