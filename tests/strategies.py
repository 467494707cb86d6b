"""Hypothesis strategies for the objects of lanindex.model.

`scores` are as an encoder or a reader of LND makes them: tracks of known stretches, each with
its starting position, symbols in order, passing rows inside the row that follows them.
`wild_scores` hold any numbers that the types allow and whose frames lie inside the capture.
"""

from fractions import Fraction
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from lanindex.alphabet import DIRECTIONS, LEVELS, PARTS
from lanindex.model import SYMBOL, Meter, Score, Span, Track

INT32 = st.integers(-(2**31), 2**31 - 1)

parts = st.sampled_from(list(PARTS))
directions = st.integers(0, len(DIRECTIONS) - 1)
levels = st.integers(0, len(LEVELS) - 1)
margins = st.integers(0, 1000).map(lambda thousandths: np.float32(thousandths / 1000))


def _hundredths(most):
    return st.integers(-1, most).map(lambda hundredths: np.float32(hundredths / 100))


measures = st.tuples(_hundredths(4094), st.integers(-1, 2046), _hundredths(126))
"""Speed, size and straightness; below 0 not known."""
tenths = st.integers(-4000, 4000).map(lambda tenths: tenths / 10)
headings = st.one_of(
    st.lists(angle, max_size=20).map(lambda values: np.array(values, np.float32))
    for angle in (tenths, st.floats(width=32))
)
rates = st.one_of(
    st.sampled_from(
        [Fraction(30), Fraction(60), Fraction(120), Fraction(30000, 1001), Fraction(25)]
    ),
    st.fractions(Fraction(1, 10), 1000),
)
meters = st.builds(
    Meter,
    speed=st.fractions(1, 400, max_denominator=1000),
    beats=st.integers(1, 12),
    beat=st.sampled_from([1, 2, 4, 8, 16]),
    division=st.integers(1, 960),
)


runners = st.one_of(st.just((-1, -1)), st.tuples(directions, levels))
_cells = st.tuples(directions, levels, margins, runners, st.integers(0, 9), st.integers(1, 99))
"""Direction, level, margin, runner-up (may be unknown), swings, rule of one row."""


_steps = st.lists(st.sampled_from(["move", "pass and move", "rest"]), max_size=7)


@st.composite
def _stretch(draw, span):
    """Return the rows of one known stretch: the starting position, then the movements."""
    rows, steps = [(span.start, span.start, False)], draw(_steps)
    cuts = st.lists(st.integers(span.start, span.stop), unique=True, max_size=len(steps) + 1)
    for step, (start, stop) in zip(steps, pairwise(sorted(draw(cuts))), strict=False):
        if step == "rest":
            continue
        if step == "pass and move" and stop - start > 1:
            rows.append((start, (start + stop) // 2, True))
        rows.append((start, stop, False))
    return rows


@st.composite
def tracks(draw, part, frames):
    """Return a track as an encoder makes it.

    A gap lies between neighbouring stretches; ticks are frames.
    """
    cuts = draw(st.lists(st.integers(0, frames), min_size=2, max_size=6, unique=True).map(sorted))
    known = tuple(Span(*cuts[index : index + 2]) for index in range(0, len(cuts) - 1, 2))
    symbols = []
    for stretch in known:
        for start, stop, passing in draw(_stretch(stretch)):
            direction, level, margin, runner, swings, rule = draw(_cells)
            span = (start, stop, start, stop - start)
            rest = (passing, rule * passing, swings, margin, *runner, -1, *draw(measures))
            symbols.append((direction, level, *span, *rest))
    return Track(part, np.array(symbols, SYMBOL), known)


@st.composite
def scores(draw, only=parts, most_frames=400):
    """Return a score as an encoder makes it, of one to three parts."""
    frames = draw(st.integers(1, most_frames))
    chosen = draw(st.lists(only, min_size=1, max_size=3, unique=True))
    return Score(
        rate=draw(rates),
        frames=frames,
        meter=draw(meters),
        tracks={part: draw(tracks(part, frames)) for part in chosen},
        heading=draw(headings),
        other=tuple(draw(st.lists(st.text(max_size=20), max_size=3))),
    )


_wild_rest = st.tuples(
    *(st.integers(0, 2**31 - 1), st.integers(0, 2**31 - 1), st.booleans()),
    *(st.integers(0, 2**16 - 1), st.integers(0, 2**24 - 1), margins),
    *(directions | st.just(-1), levels | st.just(-1), st.integers(-1, 2**15 - 2)),
    *(_hundredths(4094), st.integers(-1, 2046), _hundredths(126)),
)
"""The fields of a row from its tick on."""


@st.composite
def _wild_track(draw, part, frames):
    rows = []
    for _ in range(draw(st.integers(0, 6))):
        start, stop = sorted((draw(st.integers(0, frames)), draw(st.integers(0, frames))))
        rows.append((draw(directions), draw(levels), start, stop, *draw(_wild_rest)))
    spans = st.tuples(st.integers(0, frames), st.integers(0, frames)).map(sorted)
    known = tuple(Span(*span) for span in draw(st.lists(spans, max_size=3)))
    return Track(part, np.array(rows, SYMBOL), known)


@st.composite
def wild_scores(draw):
    """Return a score of any numbers, with frames inside the capture."""
    frames = draw(st.integers(0, 2**31 - 1))
    names = st.one_of(parts, st.text(st.characters(codec="utf-8"), min_size=1, max_size=8))
    chosen = draw(st.lists(names, max_size=4, unique=True))
    surrogates = st.text(st.characters(), max_size=8)
    return Score(
        rate=draw(st.fractions(min_value=Fraction(1, 10**30))),
        frames=frames,
        meter=Meter(draw(st.fractions()), *(draw(INT32) for _ in range(3))),
        tracks={part: draw(_wild_track(part, frames)) for part in chosen},
        heading=draw(headings),
        other=tuple(draw(st.lists(surrogates, max_size=3))),
    )


def assert_same_score(found: Score, wanted: Score) -> None:
    """Compare two scores field by field; unknown numbers equal each other."""
    assert (found.rate, found.frames, found.meter) == (wanted.rate, wanted.frames, wanted.meter)
    assert found.other == wanted.other
    np.testing.assert_array_equal(found.heading, wanted.heading)
    assert found.heading.dtype == np.float32
    assert list(found.tracks) == list(wanted.tracks)
    for part, track in wanted.tracks.items():
        assert found.tracks[part].part == part
        assert found.tracks[part].known == track.known
        for name in SYMBOL.names:
            np.testing.assert_array_equal(
                found.tracks[part].symbols[name], track.symbols[name], err_msg=f"{part} {name}"
            )
