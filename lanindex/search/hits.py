"""What a search gives back: hits as objects, dictionaries or an array."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, overload, runtime_checkable

from lanindex import records
from lanindex.errors import LanindexError
from lanindex.model import Hit
from lanindex.model.hit import in_words, readable
from lanindex.model.tabled import arrow_of, pandas_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lanindex.model import Capture, Span

FEW = 10
"""Hits that are shown of many."""


@runtime_checkable
class Lazy(Protocol):
    """Hits that are columns as long as they can be: what can be asked without making objects."""

    @property
    def captures(self) -> int:
        """In how many captures they are."""

    def tally(self) -> list[tuple[int, int]]:
        """Return the numbers of the captures, each with how many hits it has."""

    def counts(self) -> list[tuple[Capture, int]]:
        """Return the captures, each with how many hits it has."""

    def spans(self) -> Iterator[tuple[Capture, Span]]:
        """Yield capture and frames of each hit."""

    def arranged(self, order: Sequence[int]) -> Sequence[Hit]:
        """Return the same hits in another order."""

    def by_fit(self, most: int | None = None) -> Sequence[Hit]:
        """Return the same hits, the clearest first."""

    def numpy(self) -> NDArray[Any]:
        """Return the hits as an array."""


class Hits(Sequence[Hit]):
    """The hits of a search, in order, and the pattern that was searched for.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     hits = library.search("torso forward high -> hold 1s+")
    >>> len(hits), hits.pattern
    (1, 'torso forward high -> hold 1s+')
    >>> hits[0].capture.label, hits[0].span
    ('greeting', Span(start=482, stop=602))
    >>> [span.start for _, span in hits.spans()], len(hits.arranged([0, 0])), hits.counts()[0][1]
    ([482], 2, 1)
    >>> hits.to_arrow().num_rows, list(hits.to_pandas().columns)[:2]
    (1, ['capture', 'capture_id'])
    >>> hits.tally()
    [(4, 1)]
    >>> hits.by_fit()[0] == hits[0], hits.dicts()[0]["start_frame"], hits.numpy()["stop"]
    (True, 482, array([602]))
    """

    def __init__(self, found: Iterable[Hit], pattern: str) -> None:
        # what makes its hits one by one is left to do so when they are asked for
        self._hits: Sequence[Hit] = found if isinstance(found, Sequence) else tuple(found)
        self.pattern = pattern

    @overload
    def __getitem__(self, index: int) -> Hit: ...
    @overload
    def __getitem__(self, index: slice) -> Hits: ...
    def __getitem__(self, index: int | slice) -> Hit | Hits:
        """Return one hit, or some of them."""
        if isinstance(index, slice):
            return Hits(self._hits[index], self.pattern)
        return self._hits[index]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._hits)

    def __iter__(self) -> Iterator[Hit]:
        """Yield them in order."""
        return iter(self._hits)

    @property
    def captures(self) -> int:
        """In how many captures they are."""
        return self._hits.captures if isinstance(self._hits, Lazy) else len(self.tally())

    def tally(self) -> list[tuple[int, int]]:
        """Return the numbers of the captures, each with how many hits it has."""
        if isinstance(self._hits, Lazy):
            return self._hits.tally()
        return [(capture.id, count) for capture, count in self.counts()]

    def counts(self) -> list[tuple[Capture, int]]:
        """Return the captures, each with how many hits it has."""
        if isinstance(self._hits, Lazy):
            return self._hits.counts()
        captures = {hit.capture.id: hit.capture for hit in self}
        numbers = Counter(hit.capture.id for hit in self)
        return [(captures[number], count) for number, count in numbers.items()]

    def spans(self) -> Iterator[tuple[Capture, Span]]:
        """Yield capture and frames of each hit, in order."""
        if isinstance(self._hits, Lazy):
            return self._hits.spans()
        return ((hit.capture, hit.span) for hit in self)

    def arranged(self, order: Sequence[int]) -> Hits:
        """Return the same hits in another order: that of these numbers, counted from 0."""
        if isinstance(self._hits, Lazy):
            return Hits(self._hits.arranged(order), self.pattern)
        return Hits([self[number] for number in order], self.pattern)

    def __repr__(self) -> str:
        """Return the first hits, a line each."""
        lines = [
            f"  {readable(hit.path)}  {hit.when}, fit {hit.fit:.2f}" for hit in self._hits[:FEW]
        ]
        return "\n".join([f"<{self._counts()}: {readable(self.pattern)}>", *lines, *self._more()])

    def _repr_html_(self) -> str:
        """Return the first hits as a table, which a notebook shows."""
        from html import escape

        def cells(kind: str, *texts: str) -> str:
            tagged = (f"<{kind}>{escape(readable(text))}</{kind}>" for text in texts)
            return f"<tr>{''.join(tagged)}</tr>"

        rows = [
            cells("td", hit.path, hit.capture.label, hit.when, f"{hit.fit:.2f}", words)
            for hit in self._hits[:FEW]
            for words in [", ".join(in_words(hit.symbols))]
        ]
        head = cells("th", "capture", "label", "frames and seconds", "fit", "symbols")
        caption = escape(f"{self._counts()}: {readable(self.pattern)}")
        more = "".join(f"<p>{line.strip()}</p>" for line in self._more())
        return f"<table><caption>{caption}</caption>{head}{''.join(rows)}</table>{more}"

    def _counts(self) -> str:
        captures = self.captures
        return f"{len(self)} hit{'s'[: len(self) != 1]} in {captures} capture{'s'[: captures != 1]}"

    def _more(self) -> list[str]:
        if not self._hits:
            return ["  library.suggest(pattern) tells what is near"]
        return [f"  ... {len(self) - FEW} more"] if len(self) > FEW else []

    def by_fit(self, most: int | None = None) -> Hits:
        """Return the same hits, the clearest first; behind the first `most`, in any order."""
        if isinstance(self._hits, Lazy):
            return Hits(self._hits.by_fit(most), self.pattern)
        return Hits(sorted(self._hits, key=lambda hit: -hit.fit), self.pattern)

    def dicts(self) -> list[dict[str, Any]]:
        """Return the hits as dictionaries, as the command prints with ``--json``."""
        return [records.of_hit(hit, self.pattern) for hit in self._hits]

    def numpy(self) -> NDArray[Any]:
        """Return (H,) with the fields capture_id, start, stop (frames, half-open) and fit."""
        import numpy as np

        if isinstance(self._hits, Lazy):
            return self._hits.numpy()
        fields = [("capture_id", "i8"), ("start", "i8"), ("stop", "i8"), ("fit", "f4")]
        rows = [(hit.capture.id, hit.span.start, hit.span.stop, hit.fit) for hit in self._hits]
        return np.array(rows, dtype=fields)

    def to_pandas(self) -> Any:
        """Return the hits as a ``pandas.DataFrame``, as `to_frame`."""
        return pandas_of(self._columns())

    def to_arrow(self) -> Any:
        """Return the hits as a ``pyarrow.Table``, as `to_frame`."""
        return arrow_of(self._columns())

    def _columns(self) -> dict[str, list[Any]]:
        rows = self.dicts()
        return {key: [row[key] for row in rows] for key in records.HIT}

    def to_frame(self) -> Any:
        """Return the hits as a data frame of pandas, or else of polars: the columns of `dicts`.

        Raises
        ------
        LanindexError
            Where what makes the table is not installed.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     hits = library.search("torso forward high -> hold 1s+")
        >>> try:
        ...     columns = list(hits.to_frame().columns)
        ... except lanindex.LanindexError:  # with neither: the same as dictionaries
        ...     columns = list(hits.dicts()[0])
        >>> columns[:3]
        ['capture', 'capture_id', 'label']
        """
        columns = self._columns()
        for name in ("pandas", "polars"):
            try:
                return import_module(name).DataFrame(columns)
            except ModuleNotFoundError as error:
                if error.name != name:
                    raise
        raise LanindexError(
            "no library of data frames is installed",
            wanted="pandas or polars",
            remedy="Type: pip install pandas",
        )
