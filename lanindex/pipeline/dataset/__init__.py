"""Hits as a data set to train on: clips of joints, symbols and words, in splits, with a card."""

from lanindex.pipeline.dataset.splits import PERFORMERS, SPLITS, read_shares
from lanindex.pipeline.dataset.write import (
    COLUMNS,
    ClipGroup,
    DatasetOptions,
    Made,
    of_captures,
    of_hits,
    of_requests,
    write,
)

__all__ = [
    "COLUMNS",
    "PERFORMERS",
    "SPLITS",
    "ClipGroup",
    "DatasetOptions",
    "Made",
    "of_captures",
    "of_hits",
    "of_requests",
    "read_shares",
    "write",
]
