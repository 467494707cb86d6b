"""A capture of a library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from lanindex.model.score import Meter


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
    warnings : tuple of str
        What the reader found doubtful.
    told : Mapping of str to str
        What the reader was told in place of what it would have found, as in `Reading`.
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
    warnings: tuple[str, ...] = ()
    told: Mapping[str, str] = field(default_factory=dict, hash=False)
