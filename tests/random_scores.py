"""Random scores for the tests of notation and performance."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from lanindex.alphabet import DIRECTION_CODES, KINDS, PARTS, is_limb, kind_of
from lanindex.model import SYMBOL, Meter, Score, Span, Track
from lanindex.model.derived import with_bends, with_steps
from lanindex.model.symbol import blank

METERS = st.builds(
    Meter,
    speed=st.fractions(Fraction(1, 3), 240, max_denominator=12).filter(bool),
    beats=st.integers(1, 9),
    beat=st.sampled_from([2, 4, 8, 16]),
    division=st.sampled_from([32, 64, 96, 224, 480]),
)


@st.composite
def tracks(draw: st.DrawFn, part: str, ticks: int) -> Track:
    """Draw a track of a score whose frames are ticks."""
    borders = sorted(draw(st.sets(st.integers(1, ticks), min_size=2, max_size=14)))
    stretches, rows = [0], []
    kind = KINDS[kind_of(part)]
    amounts = st.sampled_from(range(len(kind.amounts))) if kind.amounts else st.integers(0, 800)
    codes = st.sampled_from([DIRECTION_CODES[name] for name in kind.directions])
    known = {"direction": codes, "level": st.integers(0, 2), "amount": amounts}

    def symbol(start: int, stop: int) -> None:
        row = blank(())
        for name in kind.fields:
            row[name] = draw(known[name])
        row["start"] = row["tick"] = start
        row["stop"], row["ticks"] = stop, stop - start
        row["margin"], row["runner_direction"], row["runner_level"] = 1, -1, -1
        rows.append(row)

    begins = is_limb(part) or "level" in kind.fields or draw(st.booleans())
    if begins:
        symbol(0, 0)
    for start, stop in pairwise(borders):
        match draw(st.sampled_from(["move", "move", "move", "hold", *["gap"] * begins])):
            case "move":
                symbol(start, stop)
            case "gap":
                symbol(start, start)
                stretches.append(start)
    edges = [*stretches, ticks]
    spans = tuple(Span(*pair) for pair in pairwise(edges))
    return Track(part, np.array(rows, SYMBOL), spans)


@st.composite
def scores(draw: st.DrawFn, known: Sequence[str] = (*PARTS, "tail")) -> Score:
    """Draw a score as LND can carry it: whole units, ticks for frames; of some parts."""
    meter = draw(METERS)
    units = draw(st.integers(1, 4))
    parts = draw(st.lists(st.sampled_from(known), max_size=3, unique=True))
    frames = units * meter.division
    found = {part: draw(tracks(part, frames)) for part in parts}
    return Score(meter.tick_rate, frames, meter, with_bends(with_steps(found)))


def seconds(score: Score) -> dict[str, list[tuple[int, int, int, Fraction, Fraction]]]:
    """Return what a score shows: direction, level, amount, start and stop in seconds."""
    rate = score.meter.tick_rate
    return {
        part: [
            (
                *(int(row[name]) for name in ("direction", "level", "amount")),
                int(row["tick"]) / rate,
                int(row["tick"] + row["ticks"]) / rate,
            )
            for row in track.symbols
            if not row["passing"]
        ]
        for part, track in score.tracks.items()
    }


def shown(score: Score) -> dict[str, list[tuple[int, ...]]]:
    """Return what a score shows: direction, level, amount, start and stop in milliseconds."""
    per = 1000 / score.rate
    return {
        part: [
            (
                *(int(row[name]) for name in ("direction", "level", "amount")),
                *(int(int(row[end]) * per + per.__class__(1, 2)) for end in ("start", "stop")),
            )
            for row in track.symbols
            if not row["passing"]
        ]
        for part, track in score.tracks.items()
        if len(track)
    }
