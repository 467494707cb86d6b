"""What a library holds, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from lanindex.library import read
from lanindex.library.link import Link

_NANO = 10**9
"""Parts of a second in which times are added up."""


@dataclass(frozen=True, slots=True)
class Stats:
    """Counts of a library.

    Attributes
    ----------
    captures, frames, symbols : int
        In all; of symbols all rows, starting positions and passing ones included.
    seconds : float
        Length of all captures.
    size : int
        Bytes of the database; 0 where it is no file.
    parts : Mapping of str to int
        Symbols by part.
    coverage : Mapping of str to float
        By part, in which share of all seconds it is known, 0 to 1.
    labels, profiles, formats : Mapping of str to int
        Captures by label, by profile (the empty name: scores that came as such), by format.
    """

    captures: int
    frames: int
    symbols: int
    seconds: float
    size: int
    parts: Mapping[str, int]
    coverage: Mapping[str, float]
    labels: Mapping[str, int]
    profiles: Mapping[str, int]
    formats: Mapping[str, int]


def count(connection: Link, size: int) -> Stats:
    """Count what a library holds.

    Parameters
    ----------
    connection : Link
        In a transaction.
    size : int
        Bytes of the database.

    Raises
    ------
    LibraryError
        If a capture is not what was stored.
    """
    stored = read.read_captures(connection)
    tracks = read.read_lists(connection)
    captures = [one.capture for one in stored]
    parts, known = Counter[str](), Counter[str]()
    for one in captures:
        for listed in tracks[one.id]:
            parts[listed.part] += listed.symbols
            frames = sum(len(span) for span in read.known_of(one, listed))
            known[listed.part] += round(frames / one.rate * _NANO)
    seconds = sum(float(one.frames / one.rate) for one in captures)
    return Stats(
        captures=len(captures),
        frames=sum(one.frames for one in captures),
        symbols=parts.total(),
        seconds=seconds,
        size=size,
        parts=_sorted(parts),
        coverage={it: round(known[it] / _NANO / seconds, 4) for it in sorted(known) if seconds},
        labels=_sorted(Counter(one.label for one in captures)),
        profiles=_sorted(Counter(one.encoding.profile for one in stored)),
        formats=_sorted(Counter(one.format for one in captures)),
    )


def parts_of(connection: Link) -> Counter[str]:
    """Return how many symbols each part has, in all captures.

    Raises
    ------
    LibraryError
        If the tracks are not those that were stored.
    """
    parts: Counter[str] = Counter()
    for tracks in read.read_lists(connection).values():
        for listed in tracks:
            parts[listed.part] += listed.symbols
    return parts


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))
