"""A symbol, and the one table of its fields.

Each field is a line of `Symbol`: its name and its form as an object, as a column of an array, in
the library and in JSON. `SYMBOL` (the dtype of a track's rows), the library's columns, its view in
words, its checks and the records all come from these lines; a new field is a new line and a
migration.

In the library small numbers share a column, each with bits of its own: `Field.column` and
`Field.shift` say where.
"""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, dataclass, field, fields
from functools import lru_cache
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, KINDS, LEVELS, kind_of


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a view of an array that cannot be written to."""
    array = array.view()
    array.flags.writeable = False
    return array


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """Frames of a source, half-open, counted from 0: the first, and the one after the last."""

    start: int
    stop: int

    def __len__(self) -> int:
        return self.stop - self.start


@dataclass(frozen=True, slots=True)
class Field:
    """How a field of a symbol is stored."""

    type: str  # Of its column in a track's rows, as numpy writes it
    column: str  # Of the library; several fields may share one
    shift: int = 0  # First bit in the column
    bits: int = 31  # How many bits it takes
    # Smallest value after scaling, stored as 0; less than 0 stands for nothing
    least: int = 0
    scale: int = 1  # Factor before it is stored as a whole number
    since: str = ""  # The field that it is stored relative to, if any
    words: tuple[str, ...] = ()  # Names by code; empty for numbers
    # Name in the library's view and in JSON; empty: that of the field
    shown: str = ""

    @property
    def most(self) -> int:
        """The largest value, as stored before `least` is taken off."""
        room = self.least + (1 << self.bits) - 1
        return min(room, len(self.words) - 1) if self.words else room

    def values(self, codes: Sequence[Any]) -> Sequence[Any]:
        """Return the values of an object: words for codes, None for nothing."""
        if self.words:
            known = (*self.words, None)
            return [known[code] for code in codes]
        if self.least >= 0:
            return codes
        if self.scale == 1:
            return [None if it < 0 else it for it in codes]
        # a float32 is none of the decimals that it stands for
        return [None if it < 0 else round(it * self.scale) / self.scale for it in codes]


def stored(type: str, column: str, default: Any = MISSING, **options: Any) -> Any:
    """Return a dataclass field with its `Field`."""
    return field(default=default, metadata={"stored": Field(type, column, **options)})


@dataclass(frozen=True, slots=True)
class Symbol:
    """One movement: a part arrives at a direction and a level.

    Attributes
    ----------
    part : str
        As in LND.
    ordinal : int
        Index of the row in its track.
    direction, level : str or None
        As in LND; None where the kind of symbol has none.
    start, stop : int
        Frames of the source, half-open; a starting position has no length.
    tick, ticks : int
        Start and length on the score's grid.
    passing : bool
        On the way: in no score, its frames lie inside the next row's.
    rule : int
        Line of the LDD rule that made it passing, else 0.
    swings : int
        Moves out and back within the direction's cell.
    margin : float
        0 at a border of the cell, 1 at the middle; in thousandths.
    runner_direction, runner_level : str or None
        The cell across the nearest border; None: none known.
    amount : int or None
        Degrees of a turn; which feet a jump leaves and lands on, as in ``alphabet.FEET``; to which
        degree a limb bends or stretches, as in ``alphabet.DEGREES_BENT``; how far an arm or a leg
        is bent that points somewhere, 0 to 6; None where there is none, or it is not known.
    speed : float or None
        The highest, in lengths of the part a second, of a way in legs, of a turn in whole turns;
        in hundredths. None where it is not known.
    size : int or None
        Whole degrees between where the part pointed before and where it points at the end.
    straightness : float or None
        The shortest way between the two over the way that was gone; in hundredths.

    Examples
    --------
    >>> import lanindex
    >>> score = lanindex.encode(lanindex.read("corpus/jumping_jacks.bvh"))
    >>> symbol = score.symbols("r_arm")[1]
    >>> print(symbol)
    r_arm right low* [60, 67)
    >>> symbol.words, symbol.span, symbol.passing, round(symbol.margin, 3), symbol.runner_up
    ('right low', Span(start=60, stop=67), True, 0.759, ('place', 'low'))
    """

    part: str
    ordinal: int
    direction: str | None = stored("i1", "sign", bits=4, least=-1, words=DIRECTIONS)
    level: str | None = stored("i1", "sign", shift=4, bits=2, least=-1, words=LEVELS)
    start: int = stored("i4", "start", shown="start_frame")
    stop: int = stored("i4", "length", since="start", shown="end_frame")
    tick: int = stored("i4", "tick")
    ticks: int = stored("i4", "ticks")
    passing: bool = stored("?", "sign", shift=12, bits=1)
    rule: int = stored("i4", "notes", shift=24, bits=16)
    swings: int = stored("i4", "notes", bits=24)
    margin: float = stored("f4", "sign", shift=13, bits=10, scale=1000)
    runner_direction: str | None = stored("i1", "sign", shift=6, bits=4, least=-1, words=DIRECTIONS)
    runner_level: str | None = stored("i1", "sign", shift=10, bits=2, least=-1, words=LEVELS)
    amount: int | None = stored("i2", "notes", shift=40, bits=15, least=-1)
    speed: float | None = stored("f4", "sign", None, shift=23, bits=12, least=-1, scale=100)
    size: int | None = stored("i2", "sign", None, shift=35, bits=11, least=-1)
    straightness: float | None = stored("f4", "sign", None, shift=46, bits=7, least=-1, scale=100)

    @property
    def span(self) -> Span:
        """Frames of the source; a starting position has no length."""
        return Span(self.start, self.stop)

    @property
    def runner_up(self) -> tuple[str, str] | None:
        """Direction and level of the cell across the nearest border."""
        if self.runner_direction is None or self.runner_level is None:
            return None
        return self.runner_direction, self.runner_level

    @property
    def words(self) -> str:
        """The symbol in words, without the part: ``right mid``, ``left 90deg``."""
        return _words(self.part, self.direction, self.level, self.amount)

    def __str__(self) -> str:
        mark = "*" if self.passing else ""
        return f"{self.part} {self.words}{mark} [{self.start}, {self.stop})"


@lru_cache(maxsize=1024)
def _words(part: str, direction: str | None, level: str | None, amount: int | None) -> str:
    kind, degree = KINDS[kind_of(part)], None
    if amount is not None and (kind.amounts or amount):
        degree = kind.amount(amount)
    return " ".join(word for word in (direction, level, degree) if word)


FIELDS: dict[str, Field] = {
    one.name: one.metadata["stored"] for one in fields(Symbol) if "stored" in one.metadata
}
"""How each field of a symbol is stored, by name."""

SYMBOL = np.dtype([(name, how.type) for name, how in FIELDS.items()])
"""One row of a track: codes, frames and numbers; what is less than 0 stands for nothing."""

_SLOTS = [getattr(Symbol, one.name).__set__ for one in fields(Symbol)]
"""What fills each slot: by columns, many symbols take half the time that `Symbol` takes one by one,
for those are frozen."""

_BYTES = np.dtype((np.void, SYMBOL.itemsize))


def listed(part: str, rows: NDArray[Any], ordinals: Iterable[int] | None = None) -> list[Symbol]:
    """Return rows, (S,) of `SYMBOL`, as objects."""
    numbers = range(len(rows)) if ordinals is None else ordinals
    columns = (how.values(rows[name].tolist()) for name, how in FIELDS.items())
    symbols = [object.__new__(Symbol) for _ in range(len(rows))]
    for put, values in zip(_SLOTS, (repeat(part), numbers, *columns), strict=True):
        deque(map(put, symbols, values), maxlen=0)
    return symbols


def blank(count: int | tuple[int, ...]) -> NDArray[Any]:
    """Return empty rows, (count,) of `SYMBOL`, absent fields less than 0."""
    rows = np.zeros(count, SYMBOL)
    for name, how in FIELDS.items():
        if how.least < 0:
            rows[name] = how.least / how.scale
    return rows


def joined(tables: Iterable[NDArray[Any]]) -> NDArray[Any]:
    """Join tables, (S,) of `SYMBOL` each: by whole rows, where numpy would copy by field."""
    rows = [table.view(_BYTES) for table in tables]
    if len(rows) == 1:
        return rows[0].view(SYMBOL)
    return np.concatenate([np.empty(0, _BYTES), *rows]).view(SYMBOL)
