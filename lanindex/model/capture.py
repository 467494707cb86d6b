"""A capture of a library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from lanindex.model.score import Meter


@dataclass(frozen=True, slots=True)
class Capture:
    """A capture or score of a library, without its symbols."""

    id: int  # Its number in the library
    path: str  # As ingested
    format: str  # ``bvh``, ``lnd`` ..., and the content's digest when it was ingested
    sha256: str
    label: str  # The user's words and other columns
    rate: Fraction  # Of the source: frames a second, how many, tempo and grid
    frames: int
    meter: Meter = field(default_factory=Meter)
    metadata: Mapping[str, str] = field(default_factory=dict, hash=False)
    location: str = ""  # The path made absolute, where its file can be found from any folder
    warnings: tuple[str, ...] = ()  # What the reader found doubtful
    # What the reader was told in place of what it would have found, as in `Reading`
    told: Mapping[str, str] = field(default_factory=dict, hash=False)
