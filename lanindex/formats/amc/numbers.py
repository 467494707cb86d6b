"""The numbers of AMC frames: each bone's, in whatever order a frame has them.

Where all frames name the bones in one order the names are blanked out, and what is left is read
as BVH's numbers are; else line by line, which says what is wrong too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.amc.asf import Bone
from lanindex.formats.bvh.compiled import Parse
from lanindex.formats.bvh.floats import fault
from lanindex.formats.bvh.hierarchy import LARGEST, text_of

Floats = NDArray[np.float64]
Places = NDArray[np.int64]


class Numbers:
    """Reads the numbers of frames."""

    def __init__(self, bones: Sequence[Bone], parse: Parse) -> None:
        self._parse = parse
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
        if len(names) != len(self.columns) or set(names) != self.columns.keys():
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
        numbers, bad = self._parse(text.tobytes(), lines[:, [0, -1]], self.width)
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
