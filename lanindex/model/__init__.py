"""The types that all packages share: Motion, Score, Hit and what they are made of.

All are frozen, their arrays read-only. Identity in time is an integer frame of the source file;
seconds exist only on screens and in JSON. Intervals are half-open: [start, stop).
"""

from lanindex.model.capture import Capture as Capture
from lanindex.model.capture import Hit as Hit
from lanindex.model.motion import Markers as Markers
from lanindex.model.motion import Motion as Motion
from lanindex.model.motion import Reading as Reading
from lanindex.model.motion import Skeleton as Skeleton
from lanindex.model.motion import Source as Source
from lanindex.model.score import Meter as Meter
from lanindex.model.score import Score as Score
from lanindex.model.score import Track as Track
from lanindex.model.symbol import SYMBOL as SYMBOL
from lanindex.model.symbol import Span as Span
from lanindex.model.symbol import Symbol as Symbol
