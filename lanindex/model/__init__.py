"""The objects that flow through the house: Motion, Score, Hit and what they are made of.

All are frozen, their arrays read-only. Identity in time is an integer frame of the source file;
seconds exist only on screens and in JSON. Intervals are half-open: [start, stop).
"""

from lanindex.model.capture import Capture
from lanindex.model.hit import Hit
from lanindex.model.motion import Markers, Motion, Skeleton, Source
from lanindex.model.reading import Reading
from lanindex.model.score import Meter, Score, Track
from lanindex.model.span import Span
from lanindex.model.symbol import SYMBOL, Symbol

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
