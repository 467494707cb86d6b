"""The engine against the plain matcher: random patterns on several small captures at once."""

from fractions import Fraction

import generated_patterns
import numpy as np
from effort import examples
from fast_search import find_fast, numbered, told
from hypothesis import assume, given
from hypothesis import strategies as st
from plain_matcher import find

from lanindex.errors import PatternError
from lanindex.model import Track
from lanindex.model.symbol import SYMBOL
from lanindex.search.language import Query, parse


@st.composite
def libraries(draw):
    """Return captures of different lengths, some with an empty track or one of a single row."""
    recordings = []
    for capture, tracks in draw(st.lists(generated_patterns.recordings(), min_size=1, max_size=4)):
        kept = dict(tracks)
        part = draw(st.sampled_from(generated_patterns.PARTS))
        if part in kept and not draw(st.integers(0, 4)):
            rows = kept[part].symbols[: draw(st.integers(0, 1))]
            kept[part] = Track(part, np.array(rows, SYMBOL), kept[part].known)
        recordings.append((capture, kept))
    return numbered(recordings)


def understood(text: str) -> Query:
    try:
        return parse(text)
    except PatternError:
        assume(False)
        raise


@examples(200)
@given(generated_patterns.lines(depth=1), libraries())
def test_lines_are_found_as_plainly(text, recordings):
    query = understood(text)
    for overlaps in ("all", "none"):
        expected = told(find(query, recordings, overlaps=overlaps))
        assert told(find_fast(query, recordings, overlaps=overlaps)) == expected


@examples(200)
@given(generated_patterns.patterns(depth=1, most=2), libraries())
def test_patterns_are_found_as_plainly(text, recordings):
    query, tolerance = understood(text), Fraction(1, 5)
    for overlaps in ("all", "none"):
        expected = told(find(query, recordings, tolerance=tolerance, overlaps=overlaps))
        found = find_fast(query, recordings, tolerance=tolerance, overlaps=overlaps)
        assert told(found) == expected
