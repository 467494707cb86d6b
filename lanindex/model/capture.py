"""A capture of a library, and a hit: what a pattern matched in it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from importlib import import_module
from itertools import chain
from os.path import commonprefix

from lanindex.model.score import Meter
from lanindex.model.symbol import Span, Symbol


@dataclass(frozen=True, slots=True)
class Capture:
    """A capture or score of a library, without its symbols."""

    id: int  # In the library
    path: str  # As ingested
    format: str  # ``bvh``, ``lnd`` ...
    sha256: str  # Of the file when it was ingested
    label: str  # From the user's table of labels
    rate: Fraction  # Frames a second of the source
    frames: int
    meter: Meter = field(default_factory=Meter)
    metadata: Mapping[str, str] = field(default_factory=dict, hash=False)  # Other columns
    location: str = ""  # The absolute path
    warnings: tuple[str, ...] = ()  # Of the reader
    # Options of the reader that the user gave, as in `Reading`
    options: Mapping[str, str] = field(default_factory=dict, hash=False)


def in_words(symbols: Iterable[Symbol]) -> list[str]:
    """Return symbols in short: a part is named where it changes."""
    words: list[str] = []
    part = ""
    for symbol in symbols:
        name = symbol.words
        words.append(name if symbol.part == part else f"{symbol.part} {name}")
        part = symbol.part
    return words


def common_folder(paths: Iterable[str]) -> str:
    """Return the folders in which all of several paths lie, with the slash behind them.

    >>> from lanindex.model.capture import common_folder
    >>> common_folder(["data/a/walk.bvh", "data/b/walk.bvh"]), common_folder(["data/walk.bvh"])
    ('data/', '')
    """
    several = list(set(paths))
    begun = commonprefix(several) if len(several) > 1 else ""  # noqa: RUF071 (cut at a slash)
    return begun[: begun.rfind("/") + 1]


def readable(text: str) -> str:
    r"""Return text as it is, or with escapes where it has what would not be seen.

    >>> from lanindex.model.capture import readable
    >>> readable("walk.bvh"), readable(chr(27) + "walk.bvh")
    ('walk.bvh', '\\x1bwalk.bvh')
    """
    return text if text.isprintable() else repr(text)[1:-1]


@dataclass(frozen=True, slots=True, repr=False)
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
    labels : Mapping of str to tuple of Symbol
        By label of the pattern, the symbols that it stands for; one that is stayed at or rested in
        has the frames of the stay or rest. No hit differs from another by these.

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
    labels: Mapping[str, tuple[Symbol, ...]] = field(
        default_factory=dict, compare=False, hash=False
    )

    def _repr_html_(self) -> str:
        """Return its poses and symbols, which a notebook shows."""
        return str(import_module("lanindex.film.notebook").of_hit(self))

    def __repr__(self) -> str:
        words = ", ".join(in_words(self.symbols))
        return f"<Hit {readable(self.path)} {self.when}, fit {self.fit:.2f}: {words}>"

    @property
    def path(self) -> str:
        """The capture's path, as ingested."""
        return self.capture.path

    @property
    def start(self) -> int:
        """The first frame of the source."""
        return self.span.start

    @property
    def stop(self) -> int:
        """The frame of the source after the last."""
        return self.span.stop

    @property
    def when(self) -> str:
        """Frames and seconds, as a person reads them."""
        begin, end = (float(frame / self.capture.rate) for frame in (self.start, self.stop))
        return f"[{self.start}, {self.stop}) {begin:.2f}-{end:.2f} s"

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """All symbols that matched, those of the leading line first."""
        return tuple(chain.from_iterable(self.lines))
