"""What a search finds."""

from __future__ import annotations

from dataclasses import dataclass

from lanindex.model.capture import Capture
from lanindex.model.span import Span
from lanindex.model.symbol import Symbol


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

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     hit = library.search("torso forward high -> hold 1s+")[0]
    >>> hit.capture.path, hit.span, round(hit.fit, 2)
    ('corpus/greetings.bvh', Span(start=482, stop=602), 1.0)
    >>> print(*hit.symbols)
    torso forward high [482, 524)
    """

    capture: Capture
    span: Span
    fit: float
    lines: tuple[tuple[Symbol, ...], ...]

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """All symbols that matched, those of the leading line first."""
        return tuple(symbol for line in self.lines for symbol in line)
