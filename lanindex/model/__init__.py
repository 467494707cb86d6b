"""The types that all packages share: Motion, Score, Hit and what they are made of.

All are frozen, their arrays read-only. Identity in time is an integer frame of the source file;
seconds exist only on screens and in JSON. Intervals are half-open: [start, stop).
"""

from lanindex.model.capture import Capture, Hit
from lanindex.model.motion import Markers, Motion, Reading, Skeleton, Source
from lanindex.model.score import Meter, Score, Track
from lanindex.model.symbol import SYMBOL, Span, Symbol

__all__ = [
    "SYMBOL",
    "Capture",
    "Hit",
    "Markers",
    "Meter",
    "Motion",
    "Reading",
    "Score",
    "Skeleton",
    "Source",
    "Span",
    "Symbol",
    "Track",
]
