"""The objects that flow through the house: Motion, Score, Hit and what they are made of.

All are frozen, their arrays read-only. Identity in time is an integer frame of the source file;
seconds exist only on screens and in JSON. Intervals are half-open: [start, stop).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, JOINTS, LEVELS
from lanindex.errors import EncodeError, UsageError

SYMBOL = np.dtype(
    [
        ("direction", "i1"),  # code of alphabet.DIRECTIONS
        ("level", "i1"),  # code of alphabet.LEVELS
        ("start", "i4"),  # frames of the source, half-open; start == stop: a starting position
        ("stop", "i4"),
        ("tick", "i4"),  # quantised start, in ticks of the score
        ("ticks", "i4"),  # quantised length
        ("passing", "?"),  # on the way: in no score, its frames lie inside the next row's
        ("rule", "i4"),  # line of the LDD rule that made it passing, else 0
        ("swings", "i4"),  # moves out and back within the direction's cell
        ("margin", "f4"),  # 0 at a border of the cell, 1 at the middle
        ("runner_direction", "i1"),  # the cell across the nearest border, -1: none known
        ("runner_level", "i1"),
    ]
)
"""One row of a track."""


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array = array.view()
    array.flags.writeable = False
    return array


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """Frames of a source, half-open, counted from 0: the first, and the one after the last."""

    start: int
    stop: int

    def __len__(self) -> int:
        """Return the number of frames."""
        return self.stop - self.start


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The joints of a capture, as its file names them.

    Attributes
    ----------
    names : tuple of str
        (J) names, parents before children.
    parents : ndarray
        (J,) int16, index of each joint's parent, -1 for a root.
    offsets : ndarray
        (J, 3) float32, mm, y up: from the parent, at rest.
    body : ndarray
        (20,) int16, index of the joint that plays each of ``alphabet.JOINTS``, -1: absent.
    """

    names: tuple[str, ...]
    parents: NDArray[np.int16]
    offsets: NDArray[np.float32]
    body: NDArray[np.int16]

    def __post_init__(self) -> None:
        """Check the shapes and freeze the arrays."""
        joints = len(self.names)
        for name, shape in (("parents", (joints,)), ("offsets", (joints, 3)), ("body", (20,))):
            array = getattr(self, name)
            if array.shape != shape:
                raise EncodeError(f"{name} has shape {array.shape}", wanted=str(shape))
            object.__setattr__(self, name, _frozen(array))

    def played(self) -> dict[str, str]:
        """Return the joints of the body model that are present, with the file's names."""
        return {
            joint: self.names[index]
            for joint, index in zip(JOINTS, self.body, strict=True)
            if index >= 0
        }


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """Where a motion comes from, and how its file was understood.

    Attributes
    ----------
    path : str
        As given.
    format : str
        ``bvh``, ...
    unit : str
        Name of the unit, with ``(detected)`` where the file does not state it.
    scale : float
        Millimetres in one unit of the file.
    up : str
        The file's vertical axis: ``y``, ``z``, ``-y`` ...
    frames : ndarray
        (T, 2) int64, first byte of each frame and the one after its last (without line end).
    content : bytes
        The file, if there is one.
    """

    path: str
    format: str
    unit: str
    scale: float
    up: str
    frames: NDArray[np.int64]
    content: bytes = field(default=b"", repr=False)

    def __post_init__(self) -> None:
        """Freeze the array."""
        object.__setattr__(self, "frames", _frozen(self.frames))

    @property
    def sha256(self) -> str:
        """Of the content, hexadecimal; worked out when it is asked for."""
        return hashlib.sha256(self.content).hexdigest() if self.content else ""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A capture: positions of joints over time.

    Attributes
    ----------
    skeleton : Skeleton
        Names and hierarchy.
    rate : Fraction
        Frames a second.
    positions : ndarray
        (T, J, 3) float32, mm, y up, right-handed; NaN where unknown.
    source : Source
        The file.
    first : int
        The first frame that is movement: 1 where frame 0 is a calibration pose, else 0.
    warnings : tuple of str
        What the reader found doubtful.
    """

    skeleton: Skeleton
    rate: Fraction
    positions: NDArray[np.float32]
    source: Source
    first: int = 0
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check shape and rate and freeze the array."""
        if self.positions.ndim != 3 or self.positions.shape[1:] != (len(self.skeleton.names), 3):
            raise EncodeError(
                f"positions have shape {self.positions.shape}",
                wanted=f"(T, {len(self.skeleton.names)}, 3)",
            )
        if self.rate <= 0:
            raise EncodeError(f"a rate of {self.rate} frames a second", wanted="more than 0")
        object.__setattr__(self, "rate", Fraction(self.rate))
        object.__setattr__(self, "positions", _frozen(self.positions))

    def __len__(self) -> int:
        """Return the number of frames."""
        return int(self.positions.shape[0])

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return float(len(self) / self.rate)

    def __repr__(self) -> str:
        """Return one line that tells the file, its size and its rate."""
        return (
            f"<Motion {self.source.path}: {len(self)} frames at {float(self.rate):g} Hz, "
            f"{self.seconds:.2f} s, {len(self.skeleton.names)} joints>"
        )


@dataclass(frozen=True, slots=True)
class Symbol:
    """One movement: a part arrives at a direction and a level.

    Attributes
    ----------
    part, direction, level : str
        As in LND.
    span : Span
        Frames of the source; a starting position has no length.
    tick, ticks, passing, swings, margin
        As in `SYMBOL`.
    runner_up : tuple of str or None
        Direction and level of the cell across the nearest border.
    ordinal : int
        Index of the row in its track.
    """

    part: str
    direction: str
    level: str
    span: Span
    tick: int
    ticks: int
    passing: bool
    swings: int
    margin: float
    runner_up: tuple[str, str] | None
    ordinal: int

    def __str__(self) -> str:
        """Return the symbol as a person would write it."""
        mark = "*" if self.passing else ""
        return (
            f"{self.part} {self.direction} {self.level}{mark} [{self.span.start}, {self.span.stop})"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """What one part of the body does, from the first frame to the last.

    Attributes
    ----------
    symbols : ndarray
        (S,) of `SYMBOL`, by time; each known stretch begins with a starting position, of no length.
    known : tuple of Span
        The stretches in which the part was seen; between them lies a gap of the capture.
    """

    part: str
    symbols: NDArray[Any]
    known: tuple[Span, ...]

    def __post_init__(self) -> None:
        """Check the dtype and freeze the array."""
        if self.symbols.dtype != SYMBOL:
            raise EncodeError(f"symbols have dtype {self.symbols.dtype}", wanted="model.SYMBOL")
        object.__setattr__(self, "symbols", _frozen(self.symbols))

    def __len__(self) -> int:
        """Return the number of rows, starting positions and passing ones included."""
        return len(self.symbols)

    def listed(self) -> list[Symbol]:
        """Return the rows as objects."""
        listed = []
        for ordinal, row in enumerate(self.symbols.tolist()):
            direction, level, start, stop, tick, ticks, passing, _, swings, margin, *runner = row
            other = (DIRECTIONS[runner[0]], LEVELS[runner[1]]) if runner[0] >= 0 else None
            head = (self.part, DIRECTIONS[direction], LEVELS[level], Span(start, stop))
            listed.append(Symbol(*head, tick, ticks, passing, swings, margin, other, ordinal))
        return listed


@dataclass(frozen=True, slots=True)
class Meter:
    """How time is counted: tempo, rhythm and the grid that symbols are rounded to.

    Attributes
    ----------
    speed : Fraction
        Beats a minute.
    beats, beat : int
        Beats in a unit (a bar), and which note is one: 4 for a quarter.
    division : int
        Ticks in a unit.
    """

    speed: Fraction = Fraction(60)
    beats: int = 4
    beat: int = 4
    division: int = 32

    @property
    def tick_rate(self) -> Fraction:
        """Ticks a second."""
        return self.speed / 60 * self.division / self.beats


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """A capture written down.

    Attributes
    ----------
    rate : Fraction
        Frames a second of the source.
    frames : int
        Frames of the source.
    meter : Meter
        Tempo, rhythm and grid.
    tracks : Mapping of str to Track
        By part.
    heading : ndarray
        (N,) float32, degrees: where the body faces, at 60 frames a second; may be empty.
    other : tuple of str
        Lines of an LND file that were not understood, kept for the way back.
    """

    rate: Fraction
    frames: int
    meter: Meter
    tracks: Mapping[str, Track]
    heading: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    other: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the array."""
        object.__setattr__(self, "heading", _frozen(self.heading))

    def __repr__(self) -> str:
        """Return one line that tells the length and the number of symbols."""
        count = f"{len(self.tracks)} parts, {sum(map(len, self.tracks.values()))} symbols"
        return f"<Score {count}, {self.frames} frames at {float(self.rate):g} Hz>"

    def symbols(self, part: str | None = None) -> list[Symbol]:
        """Return the symbols of one part, or of all, as objects.

        Raises
        ------
        UsageError
            Where the score has no such part.
        """
        if part is not None and part not in self.tracks:
            raise UsageError(f'there is no part "{part}"', wanted=f"one of {' '.join(self.tracks)}")
        parts = self.tracks if part is None else (part,)
        return [symbol for name in parts for symbol in self.tracks[name].listed()]


@dataclass(frozen=True, slots=True)
class Capture:
    """A capture or score of a library, without its symbols.

    Attributes
    ----------
    id : int
        Its number in the library.
    path : str
        As ingested.
    format, sha256 : str
        ``bvh``, ``lnd`` ..., and the content's digest when it was ingested.
    label, metadata
        The user's words and other columns.
    rate, frames, meter
        Of the source: frames a second, how many, tempo and grid.
    location : str
        The path made absolute, where its file can be found from any folder.
    """

    id: int
    path: str
    format: str
    sha256: str
    label: str
    rate: Fraction
    frames: int
    meter: Meter = field(default_factory=Meter)
    metadata: Mapping[str, str] = field(default_factory=dict, hash=False)
    location: str = ""


@dataclass(frozen=True, slots=True)
class Hit:
    """A stretch of a capture that a pattern describes.

    Attributes
    ----------
    capture : Capture
        Where.
    span : Span
        Frames of the source.
    fit : float
        0 to 1, the smallest margin of the symbols that matched.
    lines : tuple of tuple of Symbol
        The symbols that matched, line by line of the pattern.
    """

    capture: Capture
    span: Span
    fit: float
    lines: tuple[tuple[Symbol, ...], ...]

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """All symbols that matched, those of the leading line first."""
        return tuple(symbol for line in self.lines for symbol in line)
