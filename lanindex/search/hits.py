"""What a search gives back: hits as objects, dictionaries or an array."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, overload

from lanindex import records
from lanindex.model import Hit

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Hits(Sequence[Hit]):
    """The hits of a search, in order.

    Parameters
    ----------
    found : iterable of Hit
        The hits.
    pattern : str
        What was searched for.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     hits = library.search("torso forward high -> hold 1s+")
    >>> len(hits), hits.pattern
    (1, 'torso forward high -> hold 1s+')
    >>> hits[0].capture.label, hits[0].span
    ('greeting', Span(start=482, stop=602))
    >>> hits.by_fit()[0] == hits[0], hits.dicts()[0]["start_frame"], hits.numpy()["stop"]
    (True, 482, array([602]))
    """

    def __init__(self, found: Iterable[Hit], pattern: str) -> None:
        self._hits = tuple(found)
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

    def __repr__(self) -> str:
        """Return the first hits, a line each."""
        captures = len({hit.capture.id for hit in self._hits})
        counts = (
            f"{len(self)} hit{'s'[: len(self) != 1]} in {captures} capture{'s'[: captures != 1]}"
        )
        lines = [f"<{counts}: {self.pattern}>"]
        for hit in self._hits[:10]:
            begin, end = (
                records.seconds(hit.capture, frame) for frame in (hit.span.start, hit.span.stop)
            )
            lines.append(
                f"  {hit.capture.path}  [{hit.span.start}, {hit.span.stop})"
                f"  {begin:.2f}-{end:.2f} s  fit {hit.fit:.2f}"
            )
        if len(self) > 10:
            lines.append(f"  ... {len(self) - 10} more")
        return "\n".join(lines)

    def by_fit(self) -> Hits:
        """Return the same hits, the clearest first."""
        return Hits(sorted(self._hits, key=lambda hit: -hit.fit), self.pattern)

    def dicts(self) -> list[dict[str, Any]]:
        """Return the hits as dictionaries, as the command prints with ``--json``."""
        return [records.of_hit(hit) for hit in self._hits]

    def numpy(self) -> NDArray[Any]:
        """Return the hits as an array.

        Returns
        -------
        ndarray
            (H,) with the fields capture_id, start, stop (frames of the source, half-open) and
            fit.
        """
        import numpy as np

        fields = [("capture_id", "i8"), ("start", "i8"), ("stop", "i8"), ("fit", "f4")]
        rows = [(hit.capture.id, hit.span.start, hit.span.stop, hit.fit) for hit in self._hits]
        return np.array(rows, dtype=fields)
