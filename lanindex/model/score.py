"""A capture written down: tracks of symbols, and how time is counted."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from importlib import import_module
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS, kind_of
from lanindex.errors import EncodeError, LanindexError, UsageError, extra
from lanindex.model.symbol import FIELDS, SYMBOL, Span, Symbol, blank, frozen, joined, listed


class Tabular:
    """What has columns, as a table; a `LanindexError` where its library is not installed."""

    __slots__ = ()

    def columns(self) -> dict[str, Any]:
        """Return the columns by name."""
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """Return it as a ``pandas.DataFrame``."""
        return _library("pandas").DataFrame(self.columns())

    def to_arrow(self) -> Any:
        """Return it as a ``pyarrow.Table``."""
        return _library("pyarrow").table(self.columns())

    def to_frame(self) -> Any:
        """Return it as a data frame of pandas, or else of polars."""
        for name in ("pandas", "polars"):
            try:
                return import_module(name).DataFrame(self.columns())
            except ModuleNotFoundError as error:
                if error.name != name:
                    raise
        found, remedy = "no library of data frames is installed", "Type: pip install pandas"
        raise LanindexError(found, wanted="pandas or polars", remedy=remedy)


def _library(name: str) -> Any:
    with extra("tables", error_type=LanindexError):
        return import_module(name)


_COLUMNS = (
    *("direction", "level", "start_frame", "end_frame", "amount", "start", "end", "passing"),
    *("swings", "margin", "speed", "size", "straightness"),
)
"""What a symbol has in a table, in order, beside its part."""

HEADING_RATE = 60
"""Values a second of a score's heading, whatever the rates of source and profile are."""


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """What one part of the body does, from the first frame to the last."""

    part: str
    # (S,) of `SYMBOL`, by time; each known stretch begins with a starting position without length
    symbols: NDArray[Any]
    # Stretches in which the part was seen, with gaps of the capture between them
    known: tuple[Span, ...]
    kind: str = ""  # Of ``alphabet.KINDS``; by default the part's

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", self.kind or kind_of(self.part))
        if self.kind not in KINDS:
            raise EncodeError(f'the kind "{self.kind}"', wanted=f"one of {', '.join(KINDS)}")
        if self.symbols.dtype is not SYMBOL and self.symbols.dtype != SYMBOL:
            raise EncodeError(f"symbols have dtype {self.symbols.dtype}", wanted="model.SYMBOL")
        object.__setattr__(self, "symbols", frozen(self.symbols))

    def __len__(self) -> int:
        """Return the number of rows, starting positions and passing ones included."""
        return len(self.symbols)

    def listed(self) -> list[Symbol]:
        """Return the rows as objects."""
        return listed(self.part, self.symbols)


@dataclass(frozen=True, slots=True)
class Meter:
    """How time is counted: tempo, rhythm and the grid that symbols are rounded to."""

    speed: Fraction = Fraction(60)  # Beats a minute
    beats: int = 4  # In a unit (a bar)
    beat: int = 4  # Which note is a beat: 4 for a quarter
    division: int = 32  # Ticks in a unit

    @property
    def tick_rate(self) -> Fraction:
        """Ticks a second."""
        return self.speed / 60 * self.division / self.beats


@dataclass(frozen=True, slots=True, eq=False)
class Score(Tabular):
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
    warnings : tuple of str
        What was doubtful when a capture was written down.

    Examples
    --------
    >>> import lanindex
    >>> score = lanindex.read_lnd("corpus/jumping_jacks.lnd")
    >>> score
    <Score 4 parts, 60 symbols, 192 frames at 16 Hz>
    >>> sorted(score.tracks)
    ['l_arm', 'l_leg', 'r_arm', 'r_leg']
    >>> print(score.symbols("r_arm")[1])
    r_arm right high [32, 40)
    >>> list(score.columns())[:5], score.columns()["start"][1]
    (['part', 'direction', 'level', 'start_frame', 'end_frame'], 2.0)
    >>> table = score.to_frame()
    >>> table.equals(score.to_pandas()), score.to_arrow().num_rows, len(table)
    (True, 60, 60)
    """

    rate: Fraction
    frames: int
    meter: Meter
    tracks: Mapping[str, Track]
    heading: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    other: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "heading", frozen(self.heading))

    def _repr_html_(self) -> str:
        """Return its staff, which a notebook shows."""
        return str(import_module("lanindex.film.notebook").of_score(self))

    def __repr__(self) -> str:
        count = f"{len(self.tracks)} parts, {sum(map(len, self.tracks.values()))} symbols"
        return f"<Score {count}, {self.frames} frames at {float(self.rate):g} Hz>"

    def columns(self) -> dict[str, Any]:
        """Return all symbols as columns, by what JSON calls them: lists, a row each."""
        rows = joined(track.symbols for track in self.tracks.values())
        texts = {how.shown or name: how.values(rows[name].tolist()) for name, how in FIELDS.items()}
        parts = [part for part, track in self.tracks.items() for _ in range(len(track))]
        edges = {"start": rows["start"], "end": rows["stop"]}
        seconds = {it: (edges[it] / float(self.rate)).round(6).tolist() for it in edges}
        return {"part": parts, **{name: (texts | seconds)[name] for name in _COLUMNS}}

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


def rows_of(score: Score, part: str) -> NDArray[Any]:
    """Return the rows of a part that a score shows, (S,) of `SYMBOL`; none without a track."""
    rows = score.tracks[part].symbols if part in score.tracks else blank(0)
    return cast(NDArray[Any], rows[~rows["passing"]])
