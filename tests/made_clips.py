"""Random clips for the tests of search by example: rows by part, as a library keeps them."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from hypothesis import strategies as st

from lanindex.alphabet import MIRRORED, mirrored_part
from lanindex.model import Capture, Track
from lanindex.model.columns import columns_of
from lanindex.model.symbol import blank
from lanindex.search.example.likeness import Clips, ClipSource

PARTS = ("r_arm", "l_arm", "head")


@st.composite
def rows(draw: st.DrawFn, most: int = 7):
    """Draw one part's rows: a beginning, movements, some of them passing, perhaps a gap."""
    count = draw(st.integers(1, most))
    found = blank(count)
    found["direction"] = draw(st.lists(st.integers(-1, 8), min_size=count, max_size=count))
    found["level"] = draw(st.lists(st.integers(0, 2), min_size=count, max_size=count))
    found["runner_direction"] = draw(st.lists(st.integers(-1, 8), min_size=count, max_size=count))
    found["runner_level"] = draw(st.lists(st.integers(-1, 2), min_size=count, max_size=count))
    found["margin"] = draw(
        st.lists(st.sampled_from([0.0, 0.25, 1.0]), min_size=count, max_size=count)
    )
    found["swings"] = draw(st.lists(st.sampled_from([0, 0, 3]), min_size=count, max_size=count))
    lengths = draw(st.lists(st.integers(0, 40), min_size=count, max_size=count))
    found["stop"] = np.cumsum([0, *lengths[1:]])
    found["start"] = [0, *found["stop"][:-1]]
    found["passing"][1:] = draw(
        st.lists(st.sampled_from([False, False, True]), min_size=count - 1, max_size=count - 1)
    )
    return found


@st.composite
def clips(draw: st.DrawFn, most: int = 7):
    """Draw a clip: rows by part, some parts missing."""
    named = draw(st.lists(st.sampled_from(PARTS), unique=True, max_size=3))
    return {part: draw(rows(most)) for part in named}


Rows = Mapping[str, np.ndarray[Any, Any]]


def source_of(
    many: Sequence[Rows],
    rates: Sequence[float],
    parts: Sequence[str],
    frames: Sequence[int] | None = None,
) -> ClipSource:
    """Return clips, given as rows by part, as the columns of a library."""
    lengths = np.zeros(len(many), np.int64) if frames is None else np.array(frames, np.int64)
    captures = [Capture(0, "", "", "", "", Fraction(1), length) for length in lengths.tolist()]
    columns = {}
    for part in parts:
        tracks = [Track(part, clip[part], ()) if part in clip else None for clip in many]
        columns[part] = columns_of(part, captures, tracks)
    return ClipSource(columns, np.arange(len(many)), lengths, np.array(rates, np.float64))


def clips_of(many: Sequence[Rows], rates: Sequence[float], parts: Sequence[str]) -> Clips:
    """Return the same clips, laid out."""
    return source_of(many, rates, parts).clips(np.arange(len(many)))


def mirrored(clip):
    """Return a clip as a mirror shows it."""
    image = {}
    for part, found in clip.items():
        turned = found.copy()
        for name in ("direction", "runner_direction"):
            told = found[name] >= 0
            turned[name][told] = np.array(MIRRORED)[found[name][told]]
        image[mirrored_part(part)] = turned
    return image


def dance(steps):
    """Return rows of one arm that goes from cell to cell, each in half a second of 30 frames/s."""
    found = blank(len(steps))
    found["direction"], found["level"] = zip(*steps, strict=True)
    found["stop"] = 15 * np.arange(len(steps))
    found["start"] = np.maximum(found["stop"] - 15, 0)
    found["margin"] = 1
    return {"r_arm": found}
